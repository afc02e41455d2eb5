"""Time to collision: the time until the agent touches another body, for each of many velocities."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Rays
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.world.model import OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD, Model
from irsim_gym.tasks.observations.bodies.nearest_bodies import moving, span
from irsim_gym.tasks.observations.scan.free_travel import directions
from irsim_gym.tasks.terms import Bound, Columns, EpisodeState, Shard, State, Struct, Term, kernel, kind, option, row_of
from irsim_gym.tasks.terms.graph import RobotValues, Value
from irsim_gym.tasks.terms.mirrored import Mirrored, directions_exchanged
from irsim_gym.tasks.terms.term import Needs


class MovingPoint(NamedTuple):
    """A moving point in the agent's frame [m], its velocity [m/s], and the distance at which it collides [m]."""

    x: float
    y: float
    vx: float
    vy: float
    radius: float


@dataclass
class Velocities(Struct):
    """The observed velocities.

    Attributes:
        ahead: Velocities in the body frame [m/s], shape ``(n_agents, n_velocities)``.
        aside: As ``ahead``.
        radius: Radius of the disc around each agent [m], shape ``(n_agents,)``.
    """

    ahead: Rays
    aside: Rays
    radius: Floats


@kind
class ObservesTimes:
    """The options and the columns of observations of times to collision."""

    needs_goal: ClassVar[bool] = False

    directions: int = option(32, ge=1, le=1024, meaning="Number of directions; the first is straight behind.")
    speeds: int = option(1, ge=1, le=16, meaning="Number of speeds in each direction, up to ``speed``, evenly spaced.")
    speed: float | None = option(None, gt=0.0, unit="m/s", meaning="Maximum speed; default: the agent's own.")
    horizon: float = option(5.0, gt=0.0, unit="s", meaning="Maximum time; later collisions are ignored.")
    range: float | None = option(None, gt=0.0, unit="m", meaning="Bodies farther from the agent's origin are not seen.")
    margin: float = option(0.0, ge=0.0, unit="m", meaning="Added to the radius of the disc around the agent.")

    def velocities(self, model: Model, agents: Ints) -> Velocities:
        """Return the velocities in the body frame and the radii of the discs around the agents."""
        top = [fastest(model, int(b)) if self.speed is None else self.speed for b in agents]
        speeds = np.outer(top, np.arange(1, self.speeds + 1) / self.speeds).astype(np.float32)
        # Speed after speed, and all directions of each.
        ahead, aside = ((speeds[:, :, None] * unit).reshape(len(agents), -1) for unit in directions(self.directions))
        return Velocities(ahead, aside, model.reach[:, agents].max(axis=0) + self.margin)

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return 0 and 1."""
        count = self.directions * self.speeds
        return np.zeros(count, np.float32), np.ones(count, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns: the directions of each speed, slowest first."""
        table = self.velocities(model, term.agents)
        turn = 360.0 / self.directions
        angles = tuple(np.radians(turn * k - 180.0) for k in range(self.directions))
        pace = np.hypot(table.ahead[agent], table.aside[agent])[:: self.directions]
        scale = f"t = time of a disc of {float(table.radius[agent]):.3g} m to contact, as 1 - t / {self.horizon:g} s"
        sectors = tuple((angle, angle) for angle in angles)
        return [
            Columns(f"nearness in time of a collision at {speed:.3g} m/s in a direction", scale, len(angles), sectors)
            for speed in pace.tolist()
        ]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the directions from right to left."""
        return directions_exchanged(self.directions, self.speeds)

    def times_graph(self, table: Velocities, agent: int, robot: RobotValues) -> Value:
        """Return the columns of an agent as a graph; others are the discs of ``robot.bodies``."""
        rows = robot.turned_rows(robot.others(1))
        x, y, radius = rows.part(0), rows.part(1), rows.part(4)
        square, reach = x * x + y * y, radius + table.radius[agent]
        nearer = (reach * reach - square).cast(np.float32).least(0.0)
        if self.range is not None:
            nearer = (square.op("Sqrt") - radius > self.range).where(nearer * np.nan, nearer)
        x, y, vx, vy = (rows.cast(np.float32).part(k).spread(2) for k in range(4))
        ux, uy, nearer = vx - table.ahead[agent], vy - table.aside[agent], nearer.spread(2)
        # Rounded where the kernel's fused operations are: close passes amplify the last bit.
        leaving, speeds = _fused(x, ux, y * uy), _fused(ux, ux, uy * uy)
        root = _fused(leaving, leaving, speeds * nearer)
        times = ((leaving < 0.0) & (root >= 0.0)).where(nearer / (leaving - root.most(0.0).op("Sqrt")), self.horizon)
        return 1.0 - times.smallest(1).least(self.horizon) / self.horizon


@kind
class TimeToCollision(ObservesTimes):
    """Time until a disc around the agent touches another body, for velocities in evenly spaced directions.

    The agent takes up each velocity at once and keeps it, as do all other bodies, without turning (van den Berg et al.
    2008, "Reciprocal velocity obstacles", uses the same time). A time t reads ``1 - t / horizon``: 1 in contact, 0
    without a collision within the horizon. Bodies that are ``unobstructed``, and an obstacle map, are not seen.
    """

    needs: ClassVar[Needs] = ("bodies",)

    moving: bool = option(False, meaning="Whether to leave out bodies that stay where they start.")

    def arrays(self, simulation: Simulation, agents: Ints) -> Velocities:
        """Return the velocities in the body frame and the radii of the discs around the agents."""
        return self.velocities(simulation.model, agents)

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph, see ``HasGraph``; the bodies are discs."""
        return self.times_graph(term.arrays, agent, robot)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the nearness of the first collision for each velocity."""
        write_times(shard.worlds, term.bound, term.arrays, model, state, episode)


def _fused(first: Value, second: Value, rest: Value) -> Value:
    """Return ``first * second + rest`` of float32, rounded once."""
    first, second, rest = (value.cast(np.float64) for value in (first, second, rest))
    return (first * second + rest).cast(np.float32)


def fastest(model: Model, body: int) -> float:
    """Return a body's maximum speed along a linear axis of its drive [m/s]."""
    low, high = model.velocity_min[:, body], model.velocity_max[:, body]
    axes = 2 if model.drive[body] in (OMNI_WORLD, OMNI_BODY, OMNI_ANGULAR) else 1
    return float(np.maximum(np.abs(low), np.abs(high))[:, :axes].max())


@kernel
def write_times(
    worlds: Ints, term: Bound, table: Velocities, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write the nearness of the first collision for each velocity.

    Reads: term (agents, column, options), table (ahead, aside, radius), model (disc_count, disc_start, present, reach,
        segment_count, segment_start, stands, unobstructed), state (discs, pose, segments, stopped, twist), episode
        (observation).
    Writes: episode (observation).
    """
    options, horizon = term.options[0], np.float32(term.options[0].horizon)
    moving_only = options.moving != 0
    for w in worlds:
        for a in range(term.agents.shape[0]):
            own = term.agents[a]
            row = episode.observation[w, a, term.column : term.column + table.ahead.shape[1]]
            row[:] = horizon
            for b in range(model.present.shape[1]):
                if b == own or model.unobstructed[b] or not model.present[w, b] or (moving_only and model.stands[b]):
                    continue
                dx, dy = state.pose[w, b, 0] - state.pose[w, own, 0], state.pose[w, b, 1] - state.pose[w, own, 1]
                far = np.inf if np.isnan(options.range) else options.range
                if np.sqrt(dx * dx + dy * dy) - model.reach[row_of(model.reach, w), b] <= far:
                    meet_body(w, a, own, b, table, model, state, row)
            for j in range(row.shape[0]):
                row[j] = np.float32(1.0) - row[j] / horizon


@kernel
def meet_body(w: int, a: int, own: int, body: int, table: Velocities, model: Model, state: State, row: Rays) -> None:
    """Shorten the times of velocities with which the agent hits a body.

    Reads: table (ahead, aside, radius), model (disc_count, disc_start, segment_count, segment_start), state (discs,
        pose, segments, stopped, twist).
    Writes: row.
    """
    x, y, heading = state.pose[w, own, 0], state.pose[w, own, 1], state.pose[w, own, 2]
    cosine, sine = np.cos(heading), np.sin(heading)
    vx, vy = moving(w, body, 0, state), moving(w, body, 1, state)
    motion_x, motion_y = vx * cosine + vy * sine, vy * cosine - vx * sine
    ahead, aside, own_radius = table.ahead[a], table.aside[a], table.radius[a]
    first, last = span(model.disc_start, model.disc_count, w, body)
    for d in range(first, last):
        dx, dy = state.discs[w, d, 0] - x, state.discs[w, d, 1] - y
        px, py = dx * cosine + dy * sine, dy * cosine - dx * sine
        meet_disc(MovingPoint(px, py, motion_x, motion_y, own_radius + state.discs[w, d, 2]), ahead, aside, row)
    first, last = span(model.segment_start, model.segment_count, w, body)
    for s in range(first, last):
        dx, dy = state.segments[w, s, 0] - x, state.segments[w, s, 1] - y
        px, py = dx * cosine + dy * sine, dy * cosine - dx * sine
        dx, dy = state.segments[w, s, 2] - x, state.segments[w, s, 3] - y
        qx, qy = dx * cosine + dy * sine, dy * cosine - dx * sine
        end = MovingPoint(px, py, motion_x, motion_y, own_radius)
        meet_disc(end, ahead, aside, row)
        meet_disc(MovingPoint(qx, qy, motion_x, motion_y, own_radius), ahead, aside, row)
        meet_side(end, qx - px, qy - py, ahead, aside, row)


@kernel(contract=True)
def meet_disc(point: MovingPoint, ahead: Rays, aside: Rays, row: Rays) -> None:
    """Shorten the times of velocities with which a point comes closer than a radius.

    The time is the root of |p - u t| = R for the velocity u relative to the point, computed without branches so that
    the loop is vectorised. In case of overlap, velocities that reduce the distance have time 0.

    Reads: ahead, aside.
    Writes: row.
    """
    x, y, vx, vy = np.float32(point.x), np.float32(point.y), np.float32(point.vx), np.float32(point.vy)
    nothing = np.float32(0.0)
    beyond = np.float32(point.x * point.x + point.y * point.y - point.radius * point.radius)
    beyond = beyond if beyond > nothing else nothing
    for j in range(row.shape[0]):
        ux, uy = ahead[j] - vx, aside[j] - vy
        along = x * ux + y * uy
        # The smaller root of u.u t^2 - 2 p.u t + (p.p - R^2) = 0; a sum in the denominator, so that nothing cancels.
        root = along * along - (ux * ux + uy * uy) * beyond
        meets = (along > nothing) & (root >= nothing)
        time = beyond / (along + np.sqrt(root if root > nothing else nothing)) if meets else row[j]
        row[j] = time if time < row[j] else row[j]


@kernel
def meet_side(end: MovingPoint, along_x: float, along_y: float, ahead: Rays, aside: Rays, row: Rays) -> None:
    """Shorten the times of velocities with which the agent hits a segment between its ends.

    Reads: ahead, aside.
    Writes: row.
    """
    length = np.sqrt(along_x * along_x + along_y * along_y)
    if length == 0.0:
        return
    tx, ty = along_x / length, along_y / length
    # The normal points from the agent towards the segment's line; the disc touches the line when it has closed ``gap``.
    side = 1.0 if end.x * ty - end.y * tx >= 0.0 else -1.0
    nx, ny = side * ty, -side * tx
    gap, start = max(end.x * nx + end.y * ny - end.radius, 0.0), end.x * tx + end.y * ty
    for j in range(row.shape[0]):
        ux, uy = ahead[j] - end.vx, aside[j] - end.vy
        towards = ux * nx + uy * ny
        if towards <= 0.0:
            continue
        time = gap / towards
        # Where on the segment it touches, from its first end [m].
        place = time * (ux * tx + uy * ty) - start
        if time < row[j] and 0.0 <= place <= length:
            row[j] = np.float32(time)
