"""Free travel: how far the agent can drive straight in each of many directions, by its scan."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Ints, Model, Rays, Shard, State, Struct, kernel, kind, option
from irsim_gym.tasks.observations.scan import ranges as readings
from irsim_gym.tasks.observations.scan.ranges import FAR_OFF, EncodesDepths, encode, range_code
from irsim_gym.tasks.terms import Bound, Columns, EpisodeState, Needs, RobotValues, Simulation, Term, Value, coded
from irsim_gym.tasks.terms.mirrored import Mirrored, directions_exchanged


@dataclass
class Ways(Struct):
    """Observed directions, and the sensor's readings in them.

    Attributes:
        ahead_x: Directions in the body frame, shape ``(n_directions,)``.
        ahead_y: As ``ahead_x``.
        radius: Radius of the disc around each agent [m], shape ``(n_agents,)``.
        far: Maximum distance for each agent [m], shape ``(n_agents,)``.
        ranges: Live readings [m], shape ``(n_worlds, n_members, n_beams)``.
        members: Each agent's row in ``ranges``, shape ``(n_agents,)``.
        beams_x: Directions of the beams in the body frame, shape ``(n_agents, n_beams)``.
        beams_y: As ``beams_x``.
        mount: Position of the sensor in the body frame [m], shape ``(n_agents, 2)``.
        sight: Maximum range of each agent's sensor [m], shape ``(n_agents,)``.
    """

    ahead_x: Rays
    ahead_y: Rays
    radius: Rays
    far: Rays
    ranges: Rays
    members: Ints
    beams_x: Rays
    beams_y: Rays
    mount: Rays
    sight: Rays


@kind
class ObservesTravel(EncodesDepths):
    """What observations of the way that a disc can travel have in common."""

    directions: int = option(32, ge=1, le=1024, meaning="Number of directions; the first is straight behind.")
    horizon: float = option(3.0, gt=0.0, unit="m", meaning="Maximum distance; farther obstacles are ignored.")
    margin: float = option(0.0, ge=0.0, unit="m", meaning="Added to the radius of the disc around the agent.")

    problems = readings.code_problems

    def mirrored(self, term: Term) -> Mirrored:
        """Return the directions from right to left."""
        return directions_exchanged(self.directions)


@kind
class FreeTravel(ObservesTravel):
    """Encoded distance that a disc around the agent can travel, in directions evenly spaced over a full turn.

    The obstacles are the points that the beams hit. Unlike in a pooled scan, a gap that is too narrow for the agent
    appears closed, even with few directions. The codes are those of ``scan``.
    """

    needs: ClassVar[Needs] = ("scan",)

    without_sensor: str | tuple[str, ...] = readings.WITHOUT_SENSOR

    def arrays(self, simulation: Simulation, agents: Ints) -> Ways:
        """Return live ranges, each agent's row in them, the beams in the body frame, the directions and the radii."""
        group, members = readings.shared_sensors(simulation, agents, "free_travel")
        table, mounts = group.arrays, [group.options[k] for k in members]
        turned = np.array([table["angles"] + mount.offset[2] for mount in mounts])
        ahead_x, ahead_y = directions(self.directions)
        return Ways(
            ahead_x=ahead_x,
            ahead_y=ahead_y,
            radius=(simulation.model.reach[:, agents].max(axis=0) + self.margin).astype(np.float32),
            far=np.array([min(mount.range_max, self.horizon) for mount in mounts], np.float32),
            ranges=table["ranges"],
            members=members,
            beams_x=np.cos(turned).astype(np.float32),
            beams_y=np.sin(turned).astype(np.float32),
            mount=np.array([mount.offset[:2] for mount in mounts], np.float32),
            sight=np.array([mount.range_max for mount in mounts], np.float32),
        )

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the codes of the longest distance and of contact."""
        return self.coded_bounds(float(term.arrays.far.max()), self.directions)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        return way_columns(self, term.arrays, agent, float(term.arrays.far[agent]))

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        ways: Ways = term.arrays
        far, radius, (x, y) = ways.far[agent], ways.radius[agent], ways.mount[agent].astype(np.float64)
        beams = ways.beams_x[agent] + 1j * ways.beams_y[agent]
        turned = (ways.ahead_x - 1j * ways.ahead_y).astype(np.complex128)
        ranges = (robot.ranges < ways.sight[agent]).where(robot.ranges, FAR_OFF).spread(1)
        # How far each point lies along and aside each direction, ``(batch, n_directions, n_beams)``.
        along, aside = (ranges * part(np.outer(turned, beams)) for part in (np.real, np.imag))
        if x or y:
            mount = (turned * complex(x, y))[:, None]
            along, aside = along + mount.real, aside + mount.imag
        room = radius * radius - aside * aside
        lengths = ((room > 0.0) & (along > 0.0)).where(along - room.op("Sqrt"), far).smallest(2)
        return self.coded_graph(far, lengths.between(0.0, far))

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the directions' codes."""
        measure(shard.worlds, term.bound, term.arrays, episode)


def directions(count: int) -> tuple[Rays, Rays]:
    """Return cosines and sines of directions evenly spaced over a full turn, the first one straight behind."""
    ahead = 2.0 * np.pi * np.arange(count) / count - np.pi
    return np.cos(ahead).astype(np.float32), np.sin(ahead).astype(np.float32)


def way_columns(options: Any, table: Any, agent: int, far: float) -> list[Columns]:
    """Return the meaning of columns of free distances.

    Args:
        options: Options of the kind: ``directions``, ``code``, ``near`` and ``zero``.
        table: The term's ``ahead_x``, ``ahead_y`` and ``radius``.
        agent: Index of the agent.
        far: Maximum distance [m].
    """
    ahead = np.arctan2(table.ahead_y.astype(np.float64), table.ahead_x.astype(np.float64))
    # In float32, the sine of -pi may have either sign, and the angle may become +pi.
    ahead[0] = -np.pi
    scale = f"s = way of a disc of {float(table.radius[agent]):.3g} m around it, as {coded(options, 's', far)}"
    directions = tuple((angle, angle) for angle in ahead.tolist())
    return [Columns("free distance in a direction", scale, options.directions, directions)]


@kernel
def measure(worlds: Ints, term: Bound, ways: Ways, episode: EpisodeState) -> None:
    """Write the encoded free distance in each direction.

    Reads: term (column, options), ways (ahead_x, ahead_y, beams_x, beams_y, far, members, mount, radius, ranges,
        sight), episode (observation).
    Writes: episode (observation).
    """
    options, mount, beams_x, beams_y = term.options[0], ways.mount, ways.beams_x, ways.beams_y
    column = term.column
    for w in worlds:
        for a in range(ways.members.shape[0]):
            row = episode.observation[w, a, column : column + ways.ahead_x.shape[0]]
            far, radius = ways.far[a], ways.radius[a]
            row[:] = far
            scan = ways.ranges[w, ways.members[a]]
            # A point that limits a way of at most ``far`` is within ``far`` + radius of the body, and within that plus
            # the mount's distance of the sensor.
            beyond = np.sqrt(mount[a, 0] * mount[a, 0] + mount[a, 1] * mount[a, 1]) + radius
            limit = min(ways.sight[a], far + beyond)
            for k in range(scan.shape[0]):
                if scan[k] < limit:
                    x = mount[a, 0] + scan[k] * beams_x[a, k]
                    y = mount[a, 1] + scan[k] * beams_y[a, k]
                    shorten(x, y, radius * radius, far, ways.ahead_x, ways.ahead_y, row)
            encode(row, range_code(options, far))


@kernel(contract=True)
def shorten(
    x: np.float32, y: np.float32, radius2: np.float32, far: np.float32, ahead_x: Rays, ahead_y: Rays, row: Rays
) -> None:
    """Shorten the distances that a point in the body frame limits; without branches, so that the loop is vectorised."""
    nothing = np.float32(0.0)
    for j in range(row.shape[0]):
        along = x * ahead_x[j] + y * ahead_y[j]
        aside = y * ahead_x[j] - x * ahead_y[j]
        room = radius2 - aside * aside
        # The disc touches the point when its centre is sqrt(radius^2 - aside^2) before the foot of the perpendicular.
        way = along - np.sqrt(room if room > nothing else nothing)
        way = way if way > nothing else nothing
        # Only a point ahead, within the disc's width, is in the way. One that is within the disc leaves a way of 0.
        way = way if (room > nothing) & (along > nothing) else far
        row[j] = way if way < row[j] else row[j]
