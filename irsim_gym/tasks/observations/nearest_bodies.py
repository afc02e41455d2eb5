"""Nearest bodies: what stands or moves around an agent that has no range sensor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import CellMap, Floats, Ints, Rays
from irsim_gym.engine import Shard, Simulation
from irsim_gym.geometry.cells import nearest_cell_point
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind, option
from irsim_gym.tasks.observations.ranges import Code, code_number, code_problems, encoded
from irsim_gym.tasks.scaling import unit
from irsim_gym.tasks.state import EpisodeState
from irsim_gym.tasks.term import Term
from irsim_gym.tasks.words import Columns, coded
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

WIDTH = 5
FOUND = 4
"""Columns of the scratch memory: way to the nearest point (x, y), body, and whether there is one."""


@kind
class NearestBodies:
    """The nearest other bodies, nearest first, five numbers each.

    Cosine and sine of the direction of the body's nearest point in the agent's frame; the gap between that point and
    the agent's own outline, encoded as by ``scan``: 1 in contact, steep where it matters; and the relative velocity in
    the agent's frame over ``speed``. Bodies whose surface is farther from the agent's origin than ``range`` are not
    seen; one that is not there reads 0, 0, the code of ``range``, 0, 0.
    """

    only_kernels: ClassVar[bool] = True
    needs_goal: ClassVar[bool] = False
    needs_scan: ClassVar[bool] = False

    count: int = option(6, ge=1, le=64, meaning="Number of bodies observed.")
    range: float | None = option(None, gt=0.0, unit="m", meaning="How far it sees; none: the world's diagonal.")
    speed: float = option(2.0, gt=0.0, unit="m/s", meaning="Relative speed that counts as 1; faster is cut to it.")
    code: Code = option("inverse", meaning="How a gap becomes a number; see scan, with range for range_max.")
    near: float = option(0.5, gt=0.0, unit="m", meaning="Code inverse: gap at which the code has half its slope.")
    zero: float = option(0.3, ge=0.0, unit="1/m", meaning="Code inverse: value of 1 / (gap + near) that becomes 0.")

    def problems(self) -> list[tuple[str, str]]:
        """Return what is wrong with options that are right one by one: key and message."""
        return code_problems(self)

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]]:
        """Return scratch memory for the nearest bodies found so far, one row for each shard."""
        slots = simulation.shards.n_slots
        return {"distance": np.zeros((slots, self.count)), "found": np.zeros((slots, self.count, FOUND))}

    def bounds(self, term: Term, model: WorldModel) -> tuple[Rays, Rays]:
        """Return the bounds, five for each body."""
        far: Any = np.float32(_sight(self.range, model))
        least = encoded(far, code_number(self.code), np.float32(self.near), np.float32(self.zero), far)
        low = np.array([-1.0, -1.0, least, -1.0, -1.0], np.float32)
        return np.tile(low, self.count), np.ones(WIDTH * self.count, np.float32)

    def columns(self, term: Term, model: WorldModel, agent: int) -> Sequence[Columns]:
        """Return what the five numbers of each body are."""
        gap = coded(self, "g", _sight(self.range, model))
        pace = f"v / {self.speed:g} m/s, relative to the robot"
        told = [
            Columns("nearest body: cosine of its nearest point's bearing, 1 straight ahead", "0 without a body"),
            Columns("nearest body: sine of that bearing, 1 to the left", "0 without a body"),
            Columns(
                "nearest body: gap to it",
                f"g between the outlines, as {gap}",
            ),
            Columns("nearest body: speed ahead", pace),
            Columns("nearest body: speed to the left", pace),
        ]
        others = WIDTH * (self.count - 1)
        told += [Columns(f"the same five of each of the {self.count - 1} next nearest", count=others)] if others else []
        return told

    @staticmethod
    def write(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
        """Write the bodies' numbers."""
        write_nearest(
            shard.worlds,
            term.agents,
            term.column,
            _sight(term.options.range, model),
            term.options.speed,
            code_number(term.options.code),
            term.options.near,
            term.options.zero,
            model,
            state,
            episode,
            model.cells,
            term.arrays["distance"][shard.slot],
            term.arrays["found"][shard.slot],
        )


def _sight(given: float | None, model: WorldModel) -> float:
    """Return how far bodies are seen [m]: the world's diagonal where nothing is given."""
    return float(np.hypot(*(model.bounds[2:] - model.bounds[:2]))) if given is None else given


@kernel
def write_nearest(
    worlds: Ints,
    agents: Ints,
    column: int,
    far: float,
    speed: float,
    code: int,
    near: float,
    zero: float,
    model: WorldModel,
    state: WorldState,
    episode: EpisodeState,
    cells: CellMap | None,
    distance: Floats,
    found: Floats,
) -> None:
    """Write five numbers for each of the nearest bodies.

    Args:
        worlds: The worlds to treat.
        agents: Body of each agent, ``(n_agents,)``.
        column: First column of ``out``.
        far: How far bodies are seen [m].
        speed: Relative speed that counts as 1 [m/s].
        code: INVERSE or LINEAR.
        near: See ``NearestBodies`` [m].
        zero: See ``NearestBodies`` [1/m].
        cells: The obstacle map, which counts as one body at its nearest point.
        distance: Scratch, ``(count,)``.
        found: Scratch, ``(count, 4)``.
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            own = agents[a]
            x, y = state.pose[w, own, 0], state.pose[w, own, 1]
            distance[:], found[:] = far, 0.0
            for b in range(model.present.shape[1]):
                if b == own or model.unobstructed[b] or not model.present[w, b]:
                    continue
                dx, dy = state.pose[w, b, 0] - x, state.pose[w, b, 1] - y
                nearest_possible = np.sqrt(dx * dx + dy * dy) - model.reach[row_of(model.reach, w), b]
                if nearest_possible >= distance[distance.shape[0] - 1]:
                    continue
                first, last = span(model.disc_start, model.disc_count, w, b)
                gap, px, py = nearest_on_discs(state.discs[w, first:last], x, y)
                first, last = span(model.segment_start, model.segment_count, w, b)
                edge_gap, ex, ey = nearest_point(state.segments[w, first:last], x, y)
                gap, px, py = (edge_gap, ex, ey) if edge_gap < gap else (gap, px, py)
                keep(gap, px - x, py - y, b, distance, found)
            keep_cell(cells, x, y, distance, found)
            first, last = span(model.disc_start, model.disc_count, w, own)
            own_discs = state.discs[w, first:last]
            first, last = span(model.segment_start, model.segment_count, w, own)
            row = episode.observation[w, a, column : column + WIDTH * found.shape[0]]
            write_gaps(state.segments[w, first:last], own_discs, x, y, distance, found, code, near, zero, far, row)
            write_motions(w, own, found, speed, state, row)


@kernel
def span(start: Ints, count: Ints, w: int, body: int) -> tuple[int, int]:
    """Return the first row of a body's outline in a table, and the row after its last one."""
    first = int(start[body])
    return first, first + int(count[row_of(count, w), body])


@kernel
def nearest_on_discs(discs: Floats, x: float, y: float) -> tuple[float, float, float]:
    """Return distance [m] and position of the nearest point of some discs; infinity without one, 0 within one."""
    gap, px, py = np.inf, 0.0, 0.0
    for d in range(discs.shape[0]):
        dx, dy, radius = discs[d, 0] - x, discs[d, 1] - y, discs[d, 2]
        away = np.sqrt(dx * dx + dy * dy)
        if away - radius < gap:
            share = (away - radius) / away if away > 0.0 else 1.0
            gap, px, py = away - radius, x + share * dx, y + share * dy
    return gap, px, py


@kernel
def nearest_point(segments: Floats, x: float, y: float) -> tuple[float, float, float]:
    """Return distance and position of the nearest point of some segments [m]; infinity without one."""
    least, px, py = np.inf, 0.0, 0.0
    for s in range(segments.shape[0]):
        ax, ay = segments[s, 0], segments[s, 1]
        ux, uy = segments[s, 2] - ax, segments[s, 3] - ay
        length2 = ux * ux + uy * uy
        along = ((x - ax) * ux + (y - ay) * uy) / length2 if length2 > 0.0 else 0.0
        along = min(max(along, 0.0), 1.0)
        qx, qy = ax + along * ux, ay + along * uy
        here = (qx - x) * (qx - x) + (qy - y) * (qy - y)
        if here < least:
            least, px, py = here, qx, qy
    return np.sqrt(least), px, py


@kernel
def extent_towards(segments: Floats, discs: Floats, x: float, y: float, dx: float, dy: float) -> float:
    """Return how far an outline reaches from a point into a direction of any length [m]; 0 without a direction."""
    length = np.sqrt(dx * dx + dy * dy)
    farthest = 0.0
    if length == 0.0:
        return farthest
    ahead_x, ahead_y = dx / length, dy / length
    for d in range(discs.shape[0]):
        cx, cy = discs[d, 0] - x, discs[d, 1] - y
        along, aside = cx * ahead_x + cy * ahead_y, cy * ahead_x - cx * ahead_y
        room = discs[d, 2] * discs[d, 2] - aside * aside
        if room >= 0.0:
            farthest = max(farthest, along + np.sqrt(room))
    for s in range(segments.shape[0]):
        ax, ay = segments[s, 0] - x, segments[s, 1] - y
        bx, by = segments[s, 2] - x, segments[s, 3] - y
        a_aside, b_aside = ay * ahead_x - ax * ahead_y, by * ahead_x - bx * ahead_y
        if a_aside * b_aside <= 0.0 and a_aside != b_aside:
            share = a_aside / (a_aside - b_aside)
            farthest = max(farthest, (ax + share * (bx - ax)) * ahead_x + (ay + share * (by - ay)) * ahead_y)
    return farthest


@kernel
def keep(gap: float, dx: float, dy: float, body: int, distance: Floats, found: Floats) -> None:
    """Insert a body into the sorted list of the nearest ones: way to its nearest point, number, and 1 for "there"."""
    k = distance.shape[0] - 1
    if gap >= distance[k]:
        return
    while k > 0 and gap < distance[k - 1]:
        distance[k] = distance[k - 1]
        for column in range(found.shape[1]):
            found[k, column] = found[k - 1, column]
        k -= 1
    distance[k] = gap
    found[k, 0], found[k, 1], found[k, 2], found[k, 3] = dx, dy, float(body), 1.0


@kernel
def keep_cell(cells: CellMap | None, x: float, y: float, distance: Floats, found: Floats) -> None:
    """Insert the nearest occupied cell of the map, at rest, if it is near enough."""
    if cells is None:
        return
    gap, px, py = nearest_cell_point(cells, x, y, distance[distance.shape[0] - 1])
    keep(gap, px - x, py - y, cells.body, distance, found)


@kernel
def write_gaps(
    segments: Floats,
    discs: Floats,
    x: float,
    y: float,
    distance: Floats,
    found: Floats,
    code: int,
    near: float,
    zero: float,
    far: float,
    row: Rays,
) -> None:
    """Write the code of the gap between each body that was found and the agent's own segments and discs at (x, y)."""
    for k in range(found.shape[0]):
        beyond = distance[k] - extent_towards(segments, discs, x, y, found[k, 0], found[k, 1])
        gap: Any = np.float32(min(max(beyond, 0.0), far))
        row[WIDTH * k + 2] = encoded(gap, code, np.float32(near), np.float32(zero), np.float32(far))


@kernel
def write_motions(w: int, own: int, found: Floats, speed: float, state: WorldState, row: Rays) -> None:
    """Write direction and relative velocity of each body that was found, in the agent's frame."""
    cosine, sine = np.cos(state.pose[w, own, 2]), np.sin(state.pose[w, own, 2])
    for k in range(found.shape[0]):
        dx, dy, b, there = found[k, 0], found[k, 1], int(found[k, 2]), found[k, 3]
        away = np.sqrt(dx * dx + dy * dy)
        scale = 1.0 / away if away > 0.0 else 0.0
        vx = moving(w, b, 0, state) - moving(w, own, 0, state)
        vy = moving(w, b, 1, state) - moving(w, own, 1, state)
        at = WIDTH * k
        row[at] = unit((dx * cosine + dy * sine) * scale)
        row[at + 1] = unit((dy * cosine - dx * sine) * scale)
        row[at + 3] = unit(there * (vx * cosine + vy * sine) / speed)
        row[at + 4] = unit(there * (vy * cosine - vx * sine) / speed)


@kernel
def moving(w: int, b: int, axis: int, state: WorldState) -> float:
    """Return a component of a body's velocity; 0 when it is held in place."""
    return 0.0 if state.stopped[w, b] else state.twist[w, b, axis]
