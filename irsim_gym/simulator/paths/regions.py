"""Reachability with cached regions of free cells, for obstacles that stand as before.

Successive levels often have the same standing obstacles. At the second query with the same obstacles, each free cell
gets the number of its region. Later queries only look up the cells around start and goal. The result is always that of
``is_reachable``.
"""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Ints, Labels, Point
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.paths.clearance import Obstacles, way_is_free
from irsim_gym.simulator.paths.grid import BLOCKED, Grid, centre, mark_blocked
from irsim_gym.simulator.paths.reachability import FIRST, KEY, LAST, gate, is_reachable, join_runs, root

NEW, SEEN, LABELLED = 0.0, 1.0, 2.0
"""What is cached for a query: nothing, that it was asked once, and the regions. Floats, as they share a table."""


class WayTables(NamedTuple):
    """The tables of ``way_exists``: the grid, and memory whose first axis is the slot, except in a slot's own tables.

    Attributes:
        grid: The grid.
        blocked: Blocked cells, shape ``(rows, columns)``.
        runs: Runs of free cells, see ``reachability.join_runs``.
        labels: Region of each cell, see ``label_regions``, shape ``(rows, columns)``.
        known: The cached query, shape ``(n_bodies + 1, 4)``: its state (``NEW``, ``SEEN`` or ``LABELLED``) and radius
            [m] in the first row, then for each body whether it blocks, and its pose.
    """

    grid: Grid
    blocked: Bytes
    runs: Ints
    labels: Labels
    known: Floats


def way_tables(grid: Grid, n_slots: int, n_bodies: int) -> WayTables:
    """Return tables for all slots. The system provides memory only for pages that are used."""
    blocked, labels = (np.zeros((n_slots, grid.rows, grid.columns), dtype) for dtype in (np.uint8, np.int32))
    runs = np.zeros((n_slots, *grid.runs().shape), np.int64)
    return WayTables(grid, blocked, runs, labels, np.zeros((n_slots, n_bodies + 1, 4)))


def of_slot(tables: WayTables, slot: int) -> WayTables:
    """Return one slot's share of the tables."""
    grid, blocked, runs, labels, known = tables
    return WayTables(grid, blocked[slot], runs[slot], labels[slot], known[slot])


@kernel
def way_exists(obstacles: Obstacles, radius: float, start: Point, goal: Point, tables: WayTables) -> bool:
    """Return what ``is_reachable`` returns, with the cache in ``tables``, which are those of one slot.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: tables.
    """
    grid, known, labels = tables.grid, tables.known, tables.labels
    stage = recall(known, obstacles, radius) if obstacles.model.rigid[0] else NEW
    if stage == NEW:
        return is_reachable(obstacles, radius, start, goal, grid, tables.blocked, tables.runs)
    if stage == SEEN:
        label_regions(obstacles, radius, tables)
        known[0, 0] = LABELLED
    one = open_region(labels, start, grid)
    if one > 0 and one == open_region(labels, goal, grid):
        return True
    if way_is_free(obstacles, radius, start, goal):
        return True
    if not way_is_free(obstacles, radius, start, start) or not way_is_free(obstacles, radius, goal, goal):
        return False
    return regions_meet(obstacles, radius, start, goal, grid, labels)


@kernel
def recall(known: Floats, obstacles: Obstacles, radius: float) -> float:
    """Return what is cached for these obstacles and radius; if nothing is, remember this query.

    Reads: obstacles (blocks, state, w).
    Writes: known.
    """
    blocks, pose = obstacles.blocks, obstacles.state.pose[obstacles.w]
    same = known[0, 0] != NEW and known[0, 1] == radius
    for b in range(blocks.shape[0]):
        # The poses of bodies that block nothing do not count.
        same = same and known[b + 1, 0] == blocks[b]
        known[b + 1, 0] = blocks[b]
        for axis in range(3):
            same = same and (not blocks[b] or known[b + 1, 1 + axis] == pose[b, axis])
            known[b + 1, 1 + axis] = pose[b, axis]
    if same:
        return float(known[0, 0])
    known[0, 0], known[0, 1] = SEEN, radius
    return NEW


@kernel
def label_regions(obstacles: Obstacles, radius: float, tables: WayTables) -> None:
    """Write the region of each cell: 0 if it is blocked, positive if it is open, else negative.

    A cell is open if a disc of radius r + h / sqrt(2) about its centre touches nothing: then the body may stand
    anywhere in the cell, and go straight to its centre, so that start and goal in open cells of one region are joined.

    Reads: obstacles (blocks, cells, model, state, w).
    """
    grid, blocked, runs, labels, _ = tables
    mark_blocked(obstacles, radius, grid, blocked)
    count = join_runs(blocked, runs)
    columns = blocked.shape[1]
    labels[:] = 0
    for run in range(count):
        row = runs[run, KEY] // columns
        for column in range(runs[run, FIRST], runs[run, LAST] + 1):
            # 0 is kept for blocked cells.
            labels[row, column] = root(runs, run) + 1
    wide = radius + np.sqrt(0.5) * grid.cell
    # For a body of radius r, mark_blocked tests discs of radius sqrt(r^2 + h^2 / 2). This r makes that `wide`.
    mark_blocked(obstacles, np.sqrt(wide * wide - 0.5 * grid.cell * grid.cell), grid, blocked)
    for row in range(blocked.shape[0]):
        for column in range(columns):
            if blocked[row, column] == BLOCKED:
                labels[row, column] = -labels[row, column]


@kernel
def open_region(labels: Labels, point: Point, grid: Grid) -> int:
    """Return the region of the cell that holds a point [m], at most 0 if it is not open."""
    row, column = np.floor((point[1] - grid.origin_y) / grid.cell), np.floor((point[0] - grid.origin_x) / grid.cell)
    if row < 0.0 or column < 0.0 or row >= labels.shape[0] or column >= labels.shape[1]:
        return 0
    return int(labels[int(row), int(column)])


@kernel
def region(labels: Labels, row: int, column: int) -> int:
    """Return the region of a cell, 0 for one that is blocked or outside of the grid."""
    if row < 0 or column < 0 or row >= labels.shape[0] or column >= labels.shape[1]:
        return 0
    return abs(int(labels[row, column]))


@kernel
def regions_meet(obstacles: Obstacles, radius: float, start: Point, goal: Point, grid: Grid, labels: Labels) -> bool:
    """Return whether free straight lines lead from start and goal to cells of one region, out of the 16 around each.

    Reads: obstacles (blocks, cells, model, state, w).
    """
    done = 0
    for i in range(16):
        row, column = gate(i, start, grid)
        one = region(labels, row, column)
        if one == 0 or one == done or not way_is_free(obstacles, radius, start, centre(grid, row, column)):
            continue
        for j in range(16):
            row, column = gate(j, goal, grid)
            if region(labels, row, column) == one and way_is_free(obstacles, radius, goal, centre(grid, row, column)):
                return True
        # Gates that follow each other mostly belong to one region, which has failed.
        done = one
    return False
