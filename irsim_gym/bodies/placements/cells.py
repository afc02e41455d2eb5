"""cells: starts in the middle of free cells of the map, with goals that free cells connect, as in JaxNav."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from irsim_gym.base.arraytypes import CellMap, CellMaps, Flags, Floats, Ints, Point
from irsim_gym.bodies.placements import free_space
from irsim_gym.bodies.placements.free_space import WayGrids
from irsim_gym.bodies.placements.several_goals import goals_option, misfit_of_goals
from irsim_gym.simulator.cell_maps.world_maps import map_of
from irsim_gym.simulator.paths.grid import Grid
from irsim_gym.simulator.world.names import Group, Model, Shard, State, Struct, integer, kernel, kind, uniform
from irsim_gym.simulator.world.outline import place_outline

COARSE, FINE = 1.0, 0.5
"""Cell sizes of the searches for paths around standing bodies, relative to a member's reach."""


@dataclass(repr=False)
class CellTables(Struct):
    """The tables for drawing starts and goals in cells.

    Attributes:
        members: The bodies to place.
        everyone: Numbers of all bodies.
        needs_way: Whether free cells do not suffice as a proof, because bodies may stand in them or paths have limits.
        limits: Minimum and maximum length of a path [m], shape ``(2,)``.
        free: Scratch: the free cells, shape ``(n_slots, columns * rows)``.
        found: Scratch: the cells that can be reached from a start, likewise.
        seen: Scratch: the visited cells of a search, likewise.
    """

    members: Ints
    everyone: Ints
    needs_way: bool
    limits: Floats
    free: Ints
    found: Ints
    seen: Flags


@kind
class CellPlacement:
    """Starts and goals in the middle of free cells of the map, connected by cells that share sides."""

    is_random: ClassVar[bool] = True
    roams: ClassVar[bool] = True
    ensures_way: ClassVar[bool] = True
    gives_goal: ClassVar[bool] = True

    min_way_length: float = free_space.length_option("min_way_length")
    max_way_length: float | None = free_space.length_option("max_way_length")
    goals: int = goals_option()

    @property
    def n_goals(self) -> int:
        """Number of goals of each member."""
        return self.goals

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from free_space.length_problems(self.min_way_length, self.max_way_length)

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> str | None:
        """Allocate memory for searches, and return what does not fit the world."""
        frame, reaches = model.map_frame[0], model.reach[:, group.members]
        if frame.body < 0:
            return "needs an obstacle_map in the section world, among whose free cells it chooses"
        side = float(min(frame.width, frame.height))
        if reaches.max(initial=0.0) >= 0.5 * side:
            return f"needs cells wider than the members: a cell is {side:g} m wide, they reach {reaches.max():g} m"
        if (misfit := misfit_of_goals(group, model)) is not None:
            return misfit
        n_bodies, n_cells = len(model.role), int(np.prod(model.map_room.shape[1:]))
        options = group.options[0]
        # None means no maximum.
        limits = np.array([options.min_way_length, options.max_way_length or np.inf])
        needs_way = bool((model.stands & ~model.unobstructed).any() or limits[0] > 0.0 or limits[1] < np.inf)
        # Where no way is searched for, grids of a few cells save memory.
        reach = float(reaches.min(initial=side)) if needs_way else float(np.max(model.bounds[2:] - model.bounds[:2]))
        grids = [Grid.over(model.bounds, share * reach) for share in (COARSE, FINE)]
        group.tables = (
            CellTables(
                members=group.members,
                everyone=np.arange(n_bodies),
                needs_way=needs_way,
                limits=limits,
                free=np.zeros((n_slots, n_cells), np.int64),
                found=np.zeros((n_slots, n_cells), np.int64),
                seen=np.zeros((n_slots, n_cells), np.bool_),
            ),
            free_space.way_grids(grids, n_slots, n_bodies, limits.tolist()),
        )
        return None

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard, failed: Ints) -> None:
        """Draw starts and goals; ``failed[w]`` becomes body + 1 if a member finds no place."""
        tables, grids = group.tables
        cells: Any = model.cells
        draw_in_cells(shard.worlds, shard.slot, tables, grids.of_slot(shard.slot), model, state, cells, failed)

    @staticmethod
    def confirm(group: Group, model: Model, state: State, shard: Shard, failed: Ints) -> None:
        """Set ``failed`` where bodies that were placed later block a member's way, or make it too long."""
        tables, grids = group.tables
        grids = grids.of_slot(shard.slot)
        free_space.confirm_ways(shard.worlds, group.members, tables.limits, grids, model, state, model.cells, failed)


@kernel
def draw_in_cells(
    worlds: Ints,
    slot: int,
    tables: CellTables,
    grids: WayGrids,
    model: Model,
    state: State,
    cells: CellMaps,
    failed: Ints,
) -> None:
    """Place the members of each world one after another, until one finds no cell.

    Starts are drawn uniformly from the free cells, goals from the cells that the start reaches.

    Reads: tables (everyone, found, free, limits, members, needs_way, seen), model (disc_count, disc_start, drawn_goals,
        goal_renewal, has_goal, kept_clearance, local_discs, local_segments, present, reach, segment_count,
        segment_start, solid, stands, waypoint_count, waypoints), state (discs, placed, pose, random, segments).
    Writes: tables (found, free, seen), grids, model (waypoints), state (discs, placed, pose, random, segments), failed.
    """
    free = tables.free[slot]
    for w in worlds:
        world_map = map_of(cells, w)
        for b in tables.members:
            if failed[w] > 0 or not model.present[w, b] or state.placed[w, b]:
                continue
            n_free = list_free(world_map, free)
            while n_free > 0 and not state.placed[w, b]:
                n_free -= 1
                start = take(free, n_free, w, state)
                put_in_cell(world_map, start, w, state, state.pose[w, b])
                place_outline(model, state, w, b)
                if not free_space.is_start_free(w, b, tables.everyone, 0.0, model, state, cells):
                    continue
                # A start without reachable goals is given up, and the next free cell is drawn.
                state.placed[w, b] = not model.has_goal[b] or draw_goals(w, slot, b, tables, grids, model, state, cells)
            if not state.placed[w, b]:
                failed[w] = b + 1


@kernel
def draw_goals(
    w: int, slot: int, b: int, tables: CellTables, grids: WayGrids, model: Model, state: State, cells: CellMaps
) -> bool:
    """Draw the goals of body b, each from the cells that its predecessor reaches; return whether all were found.

    Reads: tables (found, limits, needs_way, seen), model (disc_count, disc_start, drawn_goals, goal_renewal, has_goal,
        kept_clearance, present, reach, segment_count, segment_start, solid, stands, waypoint_count, waypoints), state
        (discs, placed, pose, random, segments).
    Writes: tables (found, seen), grids, model (waypoints), state (random).
    """
    world_map, reached, seen = map_of(cells, w), tables.found[slot], tables.seen[slot]
    for k in range(model.drawn_goals[b]):
        begin = cell_at(world_map, free_space.leg_start(w, b, k, model, state))
        n_found, is_drawn = find_reached(world_map, begin, reached, seen), False
        while n_found > 0 and not is_drawn:
            n_found -= 1
            put_in_cell(world_map, take(reached, n_found, w, state), w, state, model.waypoints[w, b, k])
            is_drawn = free_space.is_goal_free(w, b, k, 0.0, model, state, cells) and (
                not tables.needs_way or free_space.has_way_of_length(w, b, k, tables.limits, grids, model, state, cells)
            )
        if not is_drawn:
            return False
    return True


@kernel
def cell_at(cells: CellMap, point: Point) -> int:
    """Return the index of the cell of the map that holds a point [m]."""
    column, row = (point[0] - cells.x) / cells.width, (point[1] - cells.y) / cells.height
    # Cells are numbered column by column.
    rows = int(cells.room.shape[1])
    return int(np.floor(column)) * rows + int(np.floor(row))


@kernel
def list_free(cells: CellMap, free: Ints) -> int:
    """Write the indices of the free cells, column by column; return their number."""
    rows, count = cells.room.shape[1], 0
    for i in range(cells.room.shape[0]):
        for j in range(rows):
            if cells.squares[0, i, j] > 0:
                free[count] = i * rows + j
                count += 1
    return count


@kernel
def take(numbers: Ints, last: int, w: int, state: State) -> int:
    """Draw one of the first ``last + 1`` numbers, and fill its place with the last of them.

    Reads: state (random).
    Writes: numbers, state (random).
    """
    chosen = integer(state.random, w, 0, last + 1)
    number = int(numbers[chosen])
    numbers[chosen] = numbers[last]
    return number


@kernel
def put_in_cell(cells: CellMap, cell: int, w: int, state: State, pose: Floats) -> None:
    """Write the middle of a cell [m], and draw a heading [rad].

    Reads: state (random).
    Writes: state (random), pose.
    """
    rows = cells.room.shape[1]
    pose[0] = cells.x + (cell // rows + 0.5) * cells.width
    pose[1] = cells.y + (cell % rows + 0.5) * cells.height
    pose[2] = uniform(state.random, w, -np.pi, np.pi)


@kernel
def find_reached(cells: CellMap, start: int, reached: Ints, seen: Flags) -> int:
    """Write the cells connected to a free cell by free cells that share sides; return their number.

    Args:
        cells: The map.
        start: Index of the cell, which is not written itself.
        reached: Written: indices of cells, nearest first.
        seen: Scratch: a flag for each cell.
    """
    columns, rows = cells.room.shape
    seen[:] = False
    seen[start] = True
    count, next_one, cell = 0, 0, start
    # Breadth-first search: `found` is also its queue, of which the first `next_one` entries are done.
    while True:
        i, j = cell // rows, cell % rows
        for side in range(4):
            to_i, to_j = i + (side == 0) - (side == 1), j + (side == 2) - (side == 3)
            if to_i < 0 or to_j < 0 or to_i >= columns or to_j >= rows:
                continue
            to = to_i * rows + to_j
            if not seen[to] and cells.squares[0, to_i, to_j] > 0:
                seen[to], reached[count] = True, to
                count += 1
        if next_one == count:
            return count
        cell = int(reached[next_one])
        next_one += 1
