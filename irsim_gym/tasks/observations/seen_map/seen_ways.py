"""Cells in which learners fit by their scans, and paths to their goals over these cells."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Ints, Labels, Point
from irsim_gym.simulator.cell_paths.cell_lines import free_cell, is_clear
from irsim_gym.simulator.cell_paths.scan_marks import OCCUPIED, quarter
from irsim_gym.simulator.cell_paths.wavefront import (
    NEVER,
    STRAIGHT,
    begin_costs,
    block_border,
    follow_costs,
    narrow,
    new_queues,
    spread_costs,
)
from irsim_gym.simulator.paths.grid import Grid, centre
from irsim_gym.tasks.observations.seen_map.seen_grid import SeenGrid
from irsim_gym.tasks.terms import Bound, EpisodeState, Model, Struct, kernel, row_of


@dataclass
class SeenWays(Struct):
    """Paths to the goals over cells in which learners fit, as far as their maps show.

    Attributes:
        seen: The learners' maps.
        levels: How a learner fits in each cell, see ``simulator.cell_paths.wavefront``, shape ``(n_worlds, n_agents,
            rows, columns)``; cells at the border are blocked.
        least: Lower bounds of path costs, see ``simulator.cell_paths.wavefront``, shape ``(n_worlds, n_agents, rows,
            columns)``.
        target: The goals [m] of ``least``; NaN before the first one, shape ``(n_worlds, n_agents, 2)``.
        queues: Scratch, see ``new_queues``; the first axis is the slot.
        way: Scratch for the cells of a path, shape ``(n_slots, n_cells)``.
        clearance: Distance [m] that paths keep from obstacles.
    """

    seen: SeenGrid
    levels: Bytes
    least: Labels
    target: Floats
    queues: Ints
    way: Labels
    clearance: float

    @classmethod
    def over(cls, seen: SeenGrid, slots: int, clearance: float) -> Self:
        """Return paths over empty maps that keep a distance [m] from obstacles, and scratch for ``slots`` slots."""
        shape, grid = seen.noted.shape, seen.grid
        return cls(
            seen=seen,
            levels=np.zeros((*shape, grid.rows, grid.columns), np.uint8),
            least=np.zeros((*shape, grid.rows, grid.columns), np.int32),
            target=np.full((*shape, 2), np.nan),
            queues=np.stack([new_queues(grid.rows, grid.columns)] * slots),
            way=np.zeros((slots, grid.rows * grid.columns), np.int32),
            clearance=clearance,
        )


@kernel
def clear_levels(worlds: Ints, ways: SeenWays, episode: EpisodeState) -> None:
    """Make all cells free for agents whose episodes begin, and clear their goals.

    Reads: episode (began).
    Writes: ways (levels, target).
    """
    for w in worlds:
        for a in range(episode.began.shape[1]):
            if episode.began[w, a]:
                block_border(ways.levels[w, a])
                ways.target[w, a, 0] = np.nan


@kernel
def narrow_ways(worlds: Ints, term: Bound, ways: SeenWays, model: Model, episode: EpisodeState) -> None:
    """Update the cells in which agents fit after a scan was added to their maps.

    Reads: term (agents), ways (clearance, levels, seen), model (reach), episode (steps).
    Writes: ways (levels, target).
    """
    seen = ways.seen
    for w in worlds:
        for a in range(term.agents.shape[0]):
            if seen.noted[w, a] != episode.steps[w, a]:
                continue
            fresh, levels = seen.fresh[w, a], ways.levels[w, a]
            reach = (model.reach[row_of(model.reach, w), term.agents[a]] + ways.clearance) / seen.grid.cell
            if seen.n_freed[w, a] > 0:
                rebuild(levels, seen.cells[w, a], reach)
                ways.target[w, a, 0] = np.nan
                continue
            for n in range(seen.n_fresh[w, a]):
                # Quarters are numbered on a grid that is twice as fine; 0.5 * (k + 0.5) is the middle of one [cells].
                number, columns = int(fresh[n]), 2 * seen.grid.columns
                narrow(levels, 0.5 * (number % columns + 0.5), 0.5 * (number // columns + 0.5), reach)


@kernel
def rebuild(levels: Bytes, cells: Bytes, reach: float) -> None:
    """Recompute which cells are blocked or tight from all occupied quarters of cells.

    Writes: levels.
    """
    block_border(levels)
    for i in range(cells.shape[0]):
        for j in range(cells.shape[1]):
            for k in range(4 if cells[i, j] & OCCUPIED != 0 else 0):
                if cells[i, j] & quarter(k >> 1, k) != 0:
                    narrow(levels, j + 0.25 + 0.5 * (k & 1), i + 0.25 + 0.5 * (k >> 1), reach)


@kernel
def way_ahead(ways: SeenWays, slot: int, w: int, a: int, here: Point, goal: Point) -> tuple[Point, float, int]:
    """Find the path of an agent from a point to its goal [m].

    Reads: ways (least, levels, queues, seen, target, way).
    Writes: ways (least, queues, target, way).

    Returns:
        The last point of the path that can be reached straight [m], the length of the rest of the path [m], and the
        number of cells of the path that were written. The number is 0 if the goal itself can be reached straight. It is
        0, too, if there is no path; the point is then the goal, and the length infinite.
    """
    grid = ways.seen.grid
    if is_clear(here, goal, grid, ways.levels[w, a]):
        return goal, 0.0, 0
    count = find_way(ways, slot, w, a, here, goal)
    if count == 0:
        return goal, np.inf, 0
    place = last_in_sight(here, grid, ways.levels[w, a], ways.way[slot], count)
    # Costs are whole numbers, STRAIGHT for a step of one cell.
    rest = ways.least[w, a].reshape(-1)[place] * (grid.cell / STRAIGHT)
    return (centre(grid, place // grid.columns, place % grid.columns) if rest > 0.0 else goal), rest, count


@kernel
def find_way(ways: SeenWays, slot: int, w: int, a: int, place: Point, goal: Point) -> int:
    """Write the cells of an agent's path from a point to its goal [m], and return their number; 0 without a path.

    Lower bounds of path costs are reused until the goal changes or an obstacle disappears.

    Reads: ways (least, levels, queues, seen, target, way).
    Writes: ways (least, queues, target, way).
    """
    grid, levels, least, target = ways.seen.grid, ways.levels[w, a], ways.least[w, a], ways.target[w, a]
    way = ways.way[slot]
    start = free_cell(grid, levels, place)
    if start < 0:
        return 0
    if goal[0] != target[0] or goal[1] != target[1]:
        target[0], target[1] = goal[0], goal[1]
        begin_costs(inner_cell(grid, goal), least)
    count = follow_costs(levels, least, start, way)
    # ``follow_costs`` gave up after raising many bounds: computing all costs anew is faster then. NEVER: there is no
    # path.
    if count == 0 and least.reshape(-1)[start] < NEVER:
        spread_costs(levels, inner_cell(grid, goal), ways.queues[slot], least)
        count = follow_costs(levels, least, start, way)
    return count


@kernel
def inner_cell(grid: Grid, place: Point) -> int:
    """Return the number of the cell at a point [m], or of the nearest cell inside the border."""
    column = min(max(int(np.floor((place[0] - grid.origin_x) / grid.cell)), 1), grid.columns - 2)
    row = min(max(int(np.floor((place[1] - grid.origin_y) / grid.cell)), 1), grid.rows - 2)
    return row * grid.columns + column


@kernel
def last_in_sight(place: Point, grid: Grid, levels: Bytes, way: Labels, count: int) -> int:
    """Return the number of a cell of a path, as far along it as can be reached straight from a point [m].

    The search doubles its distance along the path until a cell cannot be reached, and then bisects. The result is at
    least the second next cell.
    """
    near, far, step = min(2, count - 1), count, 2
    while near + step < count:
        if not sees(place, grid, levels, int(way[near + step])):
            far = near + step
            break
        near, step = near + step, 2 * step
    while far - near > 1:
        middle = (near + far) // 2
        if sees(place, grid, levels, int(way[middle])):
            near = middle
        else:
            far = middle
    return int(way[near])


@kernel
def sees(place: Point, grid: Grid, levels: Bytes, number: int) -> bool:
    """Return whether a cell's centre can be reached straight over free cells from a point [m]."""
    cell = centre(grid, number // grid.columns, number % grid.columns)
    return bool(is_clear(place, cell, grid, levels))
