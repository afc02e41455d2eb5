"""What learners' scans have shown as cells in which they fit, and the ways to their goals over these."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from irsim_gym.arraytypes import Bytes, Floats, Ints, Labels
from irsim_gym.engine import Simulation
from irsim_gym.jit import kernel
from irsim_gym.paths.cell_lines import free_cell, is_clear
from irsim_gym.paths.clearance import Point
from irsim_gym.paths.grid import Grid, centre
from irsim_gym.paths.scan_marks import OCCUPIED, mark_hits, mark_passed, settle_doubts
from irsim_gym.paths.wavefront import NEVER, block_border, narrow, new_queues, spread_costs, trace_costs
from irsim_gym.structs import Struct
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.observations.seen_grid import SeenGrid
from irsim_gym.tasks.term import Bound
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

NOT_PLANNED = -1
"""In place of the cost up to which costs are final."""


@dataclass
class SeenWays(Struct):
    """Costs of the ways to the goals, over cells in which learners fit as far as they know.

    Attributes:
        seen: What they know, in cells half as wide.
        grid: The cells of the ways; those at the border are blocked.
        levels: Where a learner fits, see ``paths.wavefront``, shape ``(n_worlds, n_agents, rows, columns)``.
        field: Costs of the ways, shaped as ``levels``.
        final: Cost up to which ``field`` is final, ``NOT_PLANNED`` without one, shape ``(n_worlds, n_agents)``.
        target: The goals [m] that ``field`` leads to, shape ``(n_worlds, n_agents, 2)``.
        queues: Scratch, first axis the slot: see ``new_queues``.
        way: Scratch, shape ``(n_slots, n_cells)``.
    """

    seen: SeenGrid
    grid: Grid
    levels: Bytes
    field: Labels
    final: Labels
    target: Floats
    queues: Ints
    way: Labels

    @classmethod
    def over(cls, grid: Grid, simulation: Simulation, agents: Ints, name: str) -> Self:
        """Return maps without anything, and scratch memory, for an observation of some name."""
        half = Grid(grid.origin_x, grid.origin_y, 0.5 * grid.cell, 2 * grid.columns, 2 * grid.rows)
        shape, slots = (simulation.n_worlds, len(agents)), simulation.shards.n_slots
        return cls(
            seen=SeenGrid.over(half, simulation, agents, name),
            grid=grid,
            levels=np.zeros((*shape, grid.rows, grid.columns), np.uint8),
            field=np.zeros((*shape, grid.rows, grid.columns), np.int32),
            final=np.full(shape, NOT_PLANNED, np.int32),
            target=np.full((*shape, 2), np.nan),
            queues=np.stack([new_queues(grid.rows, grid.columns)] * slots),
            way=np.zeros((slots, grid.rows * grid.columns), np.int32),
        )


@kernel
def clear_levels(worlds: Ints, ways: SeenWays, episode: EpisodeState) -> None:
    """Make all cells free for agents whose episodes begin.

    Reads: episode (began).
    Writes: ways (levels).
    """
    for w in worlds:
        for a in range(episode.began.shape[1]):
            if episode.began[w, a]:
                block_border(ways.levels[w, a])


@kernel
def note_ways(
    worlds: Ints,
    slot: int,
    term: Bound,
    ways: SeenWays,
    model: WorldModel,
    state: WorldState,
    episode: EpisodeState,
) -> None:
    """Add the latest scans to the maps, every ``every`` steps, and write where the agents fit.

    Beams are followed only where something that was seen may have moved away: unknown cells count as free.

    Reads: term (agents, options), ways (grid, levels, seen), model (reach), state (pose), episode (steps).
    Writes: ways (final, levels, seen).
    """
    seen = ways.seen
    fresh, doubted = seen.fresh[slot], seen.doubted[slot]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            if episode.steps[w, a] % term.options[0].every != 0:
                continue
            b, cells, levels = term.agents[a], seen.cells[w, a], ways.levels[w, a]
            pose, reach = state.pose[w, b], model.reach[row_of(model.reach, w), b] / ways.grid.cell
            passed = mark_passed(seen.scan, w, a, pose, seen.grid, cells, doubted) if doubted.shape[0] > 0 else 0
            count = mark_hits(seen.scan, w, a, pose, seen.grid, cells, fresh)
            for n in range(count):
                narrow_around(levels, int(fresh[n]), cells.shape[1], reach)
            if settle_doubts(cells, doubted, passed) > 0:
                rebuild(levels, cells, reach)
                ways.final[w, a] = NOT_PLANNED


@kernel
def narrow_around(levels: Bytes, number: int, columns: int, reach: float) -> None:
    """Write which cells are blocked or tight because of an occupied cell half as wide, by its number.

    Writes: levels.
    """
    narrow(levels, 0.5 * (number % columns + 0.5), 0.5 * (number // columns + 0.5), reach)


@kernel
def rebuild(levels: Bytes, cells: Bytes, reach: float) -> None:
    """Write which cells are blocked or tight because of all cells that are occupied.

    Writes: levels.
    """
    block_border(levels)
    states, columns = cells.reshape(-1), cells.shape[1]
    for number in range(states.shape[0]):
        if states[number] == OCCUPIED:
            narrow_around(levels, number, columns, reach)


@kernel
def find_way(ways: SeenWays, slot: int, w: int, a: int, place: Point, goal: Point) -> int:
    """Write the cells of an agent's way from a place to its goal [m], and return how many; 0 if there is none.

    The costs are written anew only if the goal is new, or if they do not tell the way: because something was seen in it
    or because the agent has left the cells around it.

    Reads: ways (field, final, grid, levels, queues, target).
    Writes: ways (final, queues, target, way).
    """
    grid, levels, field, target = ways.grid, ways.levels[w, a], ways.field[w, a], ways.target[w, a]
    start = free_cell(grid, levels, place)
    if start < 0:
        return 0
    if goal[0] != target[0] or goal[1] != target[1]:
        ways.final[w, a] = NOT_PLANNED
    cost, final = field.reshape(-1)[start], ways.final[w, a]
    if cost <= final and cost < NEVER:
        count = trace_costs(levels, field, start, ways.way[slot])
        if count > 0:
            return count
    elif final == NEVER:
        return 0
    target[0], target[1] = goal[0], goal[1]
    ways.final[w, a] = spread_costs(levels, inner_cell(grid, goal), start, ways.queues[slot], field)
    return trace_costs(levels, field, start, ways.way[slot]) if field.reshape(-1)[start] < NEVER else 0


@kernel
def inner_cell(grid: Grid, place: Point) -> int:
    """Return the number of the cell that holds a point [m], the nearest one within the border if that is not."""
    column = min(max(int(np.floor((place[0] - grid.origin_x) / grid.cell)), 1), grid.columns - 2)
    row = min(max(int(np.floor((place[1] - grid.origin_y) / grid.cell)), 1), grid.rows - 2)
    return row * grid.columns + column


@kernel
def last_in_sight(x: float, y: float, grid: Grid, levels: Bytes, way: Labels, count: int) -> int:
    """Return the number of a cell of a way, as far along it as can be reached straight from a place [m].

    Cells are looked at twice as far along each time, then between the last one that can be reached and the first one
    that cannot. At least the second next cell is taken.
    """
    near, far, step = min(2, count - 1), count, 2
    while near + step < count:
        if not sees(x, y, grid, levels, int(way[near + step])):
            far = near + step
            break
        near, step = near + step, 2 * step
    while far - near > 1:
        middle = (near + far) // 2
        if sees(x, y, grid, levels, int(way[middle])):
            near = middle
        else:
            far = middle
    return int(way[near])


@kernel
def sees(x: float, y: float, grid: Grid, levels: Bytes, number: int) -> bool:
    """Return whether a cell's centre can be reached straight over free cells from a place [m]."""
    to_x, to_y = centre(grid, number // grid.columns, number % grid.columns)
    return bool(is_clear(x, y, to_x, to_y, grid, levels))
