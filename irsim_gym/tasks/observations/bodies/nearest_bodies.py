"""Nearest bodies: the bodies around an agent, without a range sensor."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from irsim_gym.base.arraytypes import Cells, Floats, Ints, Rays
from irsim_gym.simulator.cell_maps.cells import nearest_cell_point
from irsim_gym.simulator.cell_maps.world_maps import map_of
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.world.model import OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD
from irsim_gym.tasks.observations.scan.ranges import EncodesDepths, RangeCode, code_problems, encoded, range_code
from irsim_gym.tasks.terms import Bound, EpisodeState, Model, Shard, State, Struct, Term, kernel, kind, option, row_of
from irsim_gym.tasks.terms.graph import RobotValues, Value
from irsim_gym.tasks.terms.mirrored import Mirrored, signed
from irsim_gym.tasks.terms.scaling import unit
from irsim_gym.tasks.terms.term import Needs
from irsim_gym.tasks.terms.words import Columns, coded

WIDTH = 5


@dataclass
class Nearest(Struct):
    """Scratch memory for the nearest bodies found so far, nearest first.

    Attributes:
        sight: Range of view [m].
        distance: Distance of each body's nearest point [m], shape ``(n_slots, count)``.
        way_x: x offset of that point [m], shape ``(n_slots, count)``.
        way_y: y offset of that point [m], shape ``(n_slots, count)``.
        body: The bodies, -1 for none, shape ``(n_slots, count)``.
    """

    sight: float
    distance: Floats
    way_x: Floats
    way_y: Floats
    body: Ints


@kind
class ObservesNearest(EncodesDepths):
    """The options and the columns of observations of the nearest bodies: five numbers each."""

    count: int = option(6, ge=1, le=64, meaning="Number of bodies observed.")
    range: float | None = option(None, gt=0.0, unit="m", meaning="Range of view; default: the world's diagonal.")
    speed: float = option(2.0, gt=0.0, unit="m/s", meaning="Relative speed that reads 1; faster speeds are clipped.")

    problems = code_problems

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds, five for each body."""
        far: Any = np.float32(_sight(self.range, model))
        least = encoded(far, RangeCode.of(self, far))
        low = np.array([-1.0, -1.0, least, -1.0, -1.0], np.float32)
        return np.tile(low, self.count), np.ones(WIDTH * self.count, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        gap = coded(self, "g", _sight(self.range, model))
        pace = f"v / {self.speed:g} m/s, relative to the robot"
        columns = [
            Columns("nearest body: cosine of its nearest point's bearing, 1 straight ahead", "0 without a body"),
            Columns("nearest body: sine of that bearing, 1 to the left", "0 without a body"),
            Columns("nearest body: gap to it", f"g between the outlines, as {gap}"),
            Columns("nearest body: speed ahead", pace),
            Columns("nearest body: speed to the left", pace),
        ]
        rest = Columns(f"the same five of each of the {self.count - 1} next nearest", count=WIDTH * (self.count - 1))
        return [*columns, rest] if self.count > 1 else columns

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns; what is positive to the left changes its sign."""
        return signed(1.0, -1.0, 1.0, 1.0, -1.0, times=self.count)

    def nearest_graph(self, far: float, model: Model, body: int, robot: RobotValues) -> Value:
        """Return the columns of a body that sees so far [m] as a graph; others are the discs of ``robot.bodies``."""
        rows = robot.others(self.count)
        dx, dy, radius = (rows.part(k) for k in (0, 1, 4))
        away = (dx * dx + dy * dy).op("Sqrt")
        gaps = away - radius
        order = (gaps < far).where(gaps, np.inf).first(self.count)
        rows, away, gap = (values.at(order) for values in (robot.turned_rows(rows), away, gaps))
        is_there = gap < far
        scale = gap.op("Sign") / away  # from inside, the nearest point lies behind
        ways = (is_there & (away > 0.0)).spread(2).where(rows.columns(0, 2, 2) * scale.spread(2), 0.0)
        depth = is_there.where(gap - extent_graph(model, body, ways.part(0), ways.part(1)), far).between(0.0, far)
        n_axes = 2 if model.drive[body] in (OMNI_WORLD, OMNI_BODY, OMNI_ANGULAR) else 1
        velocity = robot.velocity.columns(0, n_axes).times(np.eye(n_axes, 2)).spread(1)
        motion = is_there.spread(2).where((rows.columns(2, 4, 2) - velocity) / self.speed, 0.0)
        ways, motion = (values.between(-1.0, 1.0).cast(np.float32) for values in (ways, motion))
        numbers = [ways, self.coded_graph(far, depth.cast(np.float32)).spread(2), motion]
        return robot.graph.join(numbers, axis=2).op("Flatten")


@kind
class NearestBodies(ObservesNearest):
    """The nearest other bodies, nearest first, five numbers each.

    The numbers are cosine and sine of the direction of the body's nearest point in the agent's frame; the gap between
    that point and the agent's own outline, encoded as by ``scan``; and the relative velocity in the agent's frame,
    divided by ``speed``. Bodies whose surface is farther from the agent's origin than ``range`` are not seen; a missing
    body reads 0, 0, the code of ``range``, 0, 0.
    """

    needs: ClassVar[Needs] = ("bodies",)

    moving: bool = option(False, meaning="Whether to leave out bodies that stay where they start, and the map.")

    def arrays(self, simulation: Simulation, agents: Ints) -> Nearest:
        """Return scratch memory."""
        return nearest_memory(self, simulation)

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph, see ``HasGraph``; the bodies are discs."""
        return self.nearest_graph(term.arrays.sight, model, term.agents[agent], robot)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the bodies' numbers."""
        write_nearest(shard.worlds, shard.slot, term.bound, term.arrays, model, model.cells, state, episode)


def nearest_memory(options: ObservesNearest, simulation: Simulation) -> Nearest:
    """Return scratch memory for the bodies that an observation's options ask for."""
    shape = (simulation.shards.n_slots, options.count)
    far = _sight(options.range, simulation.model)
    return Nearest(far, np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros(shape, np.int64))


def _sight(far: float | None, model: Model) -> float:
    """Return the range of view [m], by default the world's diagonal."""
    return float(np.hypot(*(model.bounds[2:] - model.bounds[:2]))) if far is None else far


@kernel
def write_nearest(
    worlds: Ints,
    slot: int,
    term: Bound,
    nearest: Nearest,
    model: Model,
    cells: Cells,
    state: State,
    episode: EpisodeState,
) -> None:
    """Write five numbers for each of the nearest bodies; the obstacle map counts as one, at its nearest point.

    Reads: term (agents, column, options), nearest (body, distance, sight, way_x, way_y), model (disc_count, disc_start,
        present, reach, segment_count, segment_start, stands, unobstructed), state (discs, pose, segments, stopped,
        twist).
    Writes: nearest (body, distance, way_x, way_y), episode (observation).
    """
    distance, speed, column = nearest.distance[slot], term.options[0].speed, term.column
    n_found, moving_only = distance.shape[0], term.options[0].moving != 0
    for w in worlds:
        for a in range(term.agents.shape[0]):
            body = term.agents[a]
            x, y = state.pose[w, body, 0], state.pose[w, body, 1]
            forget_nearest(slot, nearest)
            for b in range(model.present.shape[1]):
                if b == body or model.unobstructed[b] or not model.present[w, b] or (moving_only and model.stands[b]):
                    continue
                dx, dy = state.pose[w, b, 0] - x, state.pose[w, b, 1] - y
                # Not nearer than the last one in the list, whatever its outline is: skip the exact search.
                nearest_possible = np.sqrt(dx * dx + dy * dy) - model.reach[row_of(model.reach, w), b]
                if nearest_possible >= distance[n_found - 1]:
                    continue
                first, last = span(model.disc_start, model.disc_count, w, b)
                gap, px, py = nearest_on_discs(state.discs[w, first:last], x, y)
                first, last = span(model.segment_start, model.segment_count, w, b)
                edge_gap, ex, ey = nearest_point(state.segments[w, first:last], x, y)
                gap, px, py = (edge_gap, ex, ey) if edge_gap < gap else (gap, px, py)
                keep(gap, px - x, py - y, b, slot, nearest)
            if cells is not None and not moving_only:
                gap, px, py = nearest_cell_point(map_of(cells, w), x, y, distance[n_found - 1])
                keep(gap, px - x, py - y, cells.body, slot, nearest)
            row = episode.observation[w, a, column : column + WIDTH * n_found]
            write_gaps(w, body, slot, nearest, term, model, state, row)
            write_motions(w, body, slot, nearest, speed, state, row)


@kernel
def forget_nearest(slot: int, nearest: Nearest) -> None:
    """Forget all bodies of the list: each place is as far as the sight.

    Reads: nearest (sight).
    Writes: nearest (body, distance, way_x, way_y).
    """
    nearest.distance[slot, :], nearest.way_x[slot, :], nearest.way_y[slot, :] = nearest.sight, 0.0, 0.0
    nearest.body[slot, :] = -1


@kernel
def span(start: Ints, count: Ints, w: int, body: int) -> tuple[int, int]:
    """Return the first row of a body's outline in a table, and the row after its last one."""
    first = int(start[body])
    return first, first + int(count[row_of(count, w), body])


@kernel
def nearest_on_discs(discs: Floats, x: float, y: float) -> tuple[float, float, float]:
    """Return distance and position of the nearest point of some discs [m]; infinity without discs, negative inside."""
    gap, px, py = np.inf, 0.0, 0.0
    for d in range(discs.shape[0]):
        dx, dy, radius = discs[d, 0] - x, discs[d, 1] - y, discs[d, 2]
        away = np.sqrt(dx * dx + dy * dy)
        if away - radius < gap:
            # From inside, the distance is negative, and the point on the edge lies behind.
            share = (away - radius) / away if away > 0.0 else 1.0
            gap, px, py = away - radius, x + share * dx, y + share * dy
    return gap, px, py


@kernel
def nearest_point(segments: Floats, x: float, y: float) -> tuple[float, float, float]:
    """Return distance and position of the nearest point of some segments [m]; infinity without segments."""
    least, px, py = np.inf, 0.0, 0.0
    for s in range(segments.shape[0]):
        ax, ay = segments[s, 0], segments[s, 1]
        ux, uy = segments[s, 2] - ax, segments[s, 3] - ay
        length2 = ux * ux + uy * uy
        along = ((x - ax) * ux + (y - ay) * uy) / length2 if length2 > 0.0 else 0.0
        along = min(max(along, 0.0), 1.0)
        qx, qy = ax + along * ux, ay + along * uy
        distance2 = (qx - x) * (qx - x) + (qy - y) * (qy - y)
        if distance2 < least:
            least, px, py = distance2, qx, qy
    return np.sqrt(least), px, py


@kernel
def extent_towards(segments: Floats, discs: Floats, x: float, y: float, dx: float, dy: float) -> float:
    """Return the extent of an outline from a point in a direction of any length [m]; 0 without a direction."""
    length = np.sqrt(dx * dx + dy * dy)
    farthest = 0.0
    if length == 0.0:
        return farthest
    ahead_x, ahead_y = dx / length, dy / length
    for d in range(discs.shape[0]):
        cx, cy = discs[d, 0] - x, discs[d, 1] - y
        along, aside = cx * ahead_x + cy * ahead_y, cy * ahead_x - cx * ahead_y
        # Half of the chord, squared: the ray in the direction leaves the disc at ``along`` + half of the chord.
        room = discs[d, 2] * discs[d, 2] - aside * aside
        if room >= 0.0:
            farthest = max(farthest, along + np.sqrt(room))
    for s in range(segments.shape[0]):
        ax, ay = segments[s, 0] - x, segments[s, 1] - y
        bx, by = segments[s, 2] - x, segments[s, 3] - y
        # Distances of both ends from the line of the direction, with sign: if they differ, the segment crosses it.
        a_aside, b_aside = ay * ahead_x - ax * ahead_y, by * ahead_x - bx * ahead_y
        if a_aside * b_aside <= 0.0 and a_aside != b_aside:
            share = a_aside / (a_aside - b_aside)
            farthest = max(farthest, (ax + share * (bx - ax)) * ahead_x + (ay + share * (by - ay)) * ahead_y)
    return farthest


def extent_graph(model: Model, body: int, ahead: Value, left: Value) -> Value:
    """Return what ``extent_towards`` returns of a body's own outline, as a graph, ``(batch, count)``.

    Args:
        body: The body.
        ahead: Directions in its frame, of length 1 or 0, ``(batch, count)``.
        left: As ``ahead``.
    """
    first, last = span(model.disc_start, model.disc_count, 0, body)
    discs, ahead, left = model.local_discs[0, first:last], ahead.spread(2), left.spread(2)
    first, last = span(model.segment_start, model.segment_count, 0, body)
    (x, y, radius), (ax, ay, bx, by) = discs.T, model.local_segments[0, first:last].T
    extents = [ahead * 0.0]
    if len(x):
        aside = ahead * y - left * x
        room = -(aside * aside - radius * radius)
        extents.append((room >= 0.0).where(ahead * x + left * y + room.most(0.0).op("Sqrt"), 0.0))
    if len(ax):
        a_aside, b_aside = ahead * ay - left * ax, ahead * by - left * bx
        share = a_aside / (a_aside - b_aside)
        along = (share * (bx - ax) + ax) * ahead + (share * (by - ay) + ay) * left
        extents.append((~(a_aside * b_aside > 0.0) & ~a_aside.equals(b_aside)).where(along, 0.0))
    is_direction = ahead * ahead + left * left > 0.5
    return is_direction.where(ahead.graph.join(extents, axis=2), 0.0).largest(2)


@kernel
def keep(gap: float, dx: float, dy: float, body: int, slot: int, nearest: Nearest) -> None:
    """Insert a body, and the offset of its nearest point, into the sorted list of the nearest bodies.

    Reads: nearest (body, distance, way_x, way_y).
    Writes: nearest (body, distance, way_x, way_y).
    """
    distance, way_x = nearest.distance[slot], nearest.way_x[slot]
    way_y, bodies = nearest.way_y[slot], nearest.body[slot]
    k = distance.shape[0] - 1
    if gap >= distance[k]:
        return
    while k > 0 and gap < distance[k - 1]:
        distance[k], way_x[k], way_y[k], bodies[k] = distance[k - 1], way_x[k - 1], way_y[k - 1], bodies[k - 1]
        k -= 1
    distance[k], way_x[k], way_y[k], bodies[k] = gap, dx, dy, body


@kernel
def write_gaps(
    w: int, body: int, slot: int, nearest: Nearest, term: Bound, model: Model, state: State, row: Rays
) -> None:
    """Write the code of the gap between each found body and the agent's own outline.

    Reads: nearest (distance, sight, way_x, way_y), term (options), model (disc_count, disc_start, segment_count,
        segment_start), state (discs, pose, segments).
    Writes: row.
    """
    far = nearest.sight
    code = range_code(term.options[0], far)
    first, last = span(model.segment_start, model.segment_count, w, body)
    segments = state.segments[w, first:last]
    first, last = span(model.disc_start, model.disc_count, w, body)
    discs = state.discs[w, first:last]
    x, y = state.pose[w, body, 0], state.pose[w, body, 1]
    for k in range(nearest.distance.shape[1]):
        extent = extent_towards(segments, discs, x, y, nearest.way_x[slot, k], nearest.way_y[slot, k])
        gap: Any = np.float32(min(max(nearest.distance[slot, k] - extent, 0.0), far))
        row[WIDTH * k + 2] = encoded(gap, code)


@kernel
def write_motions(w: int, body: int, slot: int, nearest: Nearest, speed: float, state: State, row: Rays) -> None:
    """Write direction and relative velocity of each found body, in the agent's frame.

    Reads: nearest (body, way_x, way_y), state (pose, stopped, twist).
    Writes: row.
    """
    cosine, sine = np.cos(state.pose[w, body, 2]), np.sin(state.pose[w, body, 2])
    for k in range(nearest.distance.shape[1]):
        b, vx, vy = nearest.body[slot, k], 0.0, 0.0
        if b >= 0:
            vx, vy = (
                moving(w, b, 0, state) - moving(w, body, 0, state),
                moving(w, b, 1, state) - moving(w, body, 1, state),
            )
        way = nearest.way_x[slot, k], nearest.way_y[slot, k]
        write_motion(way, (vx, vy), (cosine, sine), speed, row[WIDTH * k : WIDTH * (k + 1)])


@kernel
def write_motion(
    way: tuple[float, float], motion: tuple[float, float], ahead: tuple[float, float], speed: float, row: Rays
) -> None:
    """Write the direction of a way [m] and a relative velocity [m/s] in an agent's frame.

    Writes: row.

    Args:
        way: The way to the body's nearest point.
        motion: Its velocity relative to the agent's.
        ahead: Cosine and sine of the agent's heading.
        speed: The speed that reads 1.
        row: The five numbers of a body; the gap, which is the third, is not written.
    """
    (dx, dy), (vx, vy), (cosine, sine) = way, motion, ahead
    away = np.sqrt(dx * dx + dy * dy)
    scale = 1.0 / away if away > 0.0 else 0.0
    row[0] = unit((dx * cosine + dy * sine) * scale)
    row[1] = unit((dy * cosine - dx * sine) * scale)
    row[3] = unit((vx * cosine + vy * sine) / speed)
    row[4] = unit((vy * cosine - vx * sine) / speed)


@kernel
def moving(w: int, b: int, axis: int, state: State) -> float:
    """Return a component of a body's velocity; 0 if the body is stopped.

    Reads: state (stopped, twist).
    """
    return 0.0 if state.stopped[w, b] else state.twist[w, b, axis]
