"""Ways among bodies that stand as they stood before: the regions of free cells are found once, and then looked up.

A level often differs from the one before in nothing that stands. The second time that something is asked among the
same bodies, each free cell gets the number of its region; from then on an answer takes a few looks at the cells
around start and goal. It is always that of ``is_reachable``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Bytes, Flags, Floats, Ints, Labels
from irsim_gym.jit import kernel
from irsim_gym.paths.clearance import Outlines, way_is_free
from irsim_gym.paths.grid import BLOCKED, Grid, mark_blocked
from irsim_gym.paths.reachability import FIRST, KEY, LAST, gate, is_reachable, join_runs, root

NEW, SEEN, LABELLED = 0.0, 1.0, 2.0

WayTables = tuple[Floats, Bytes, Ints, Labels, Floats]


def way_tables(grid: Grid, n_slots: int, n_bodies: int) -> WayTables:
    """Return what ``way_exists`` works on: the frame, shared, and memory with one row for each slot.

    These are the blocked cells, runs, labels ``(n_slots, rows, columns)`` and what is known, ``(n_slots, n_bodies + 1,
    4)``: how far (``NEW``, ``SEEN`` or ``LABELLED``) and for which radius [m] in the first row, then for each body
    whether it blocks, and where it stands. Memory that is never used is never claimed from the system.
    """
    shape = n_slots, grid.rows, grid.columns
    return (
        np.array([grid.origin_x, grid.origin_y, grid.cell]),
        np.zeros(shape, np.uint8),
        np.zeros((n_slots, *grid.runs().shape), np.int64),
        np.zeros(shape, np.int32),
        np.zeros((n_slots, n_bodies + 1, 4)),
    )


def of_slot(tables: Sequence[NDArray[Any]], slot: int) -> WayTables:
    """Return one slot's share of the tables."""
    frame, blocked, runs, labels, known = tables
    return frame, blocked[slot], runs[slot], labels[slot], known[slot]


@kernel
def way_exists(
    outlines: Outlines,
    pose: Floats,
    rigid: bool,
    radius: float,
    start_x: float,
    start_y: float,
    goal_x: float,
    goal_y: float,
    tables: WayTables,
) -> bool:
    """Return what ``is_reachable`` says.

    Args:
        outlines: The nine tables of one world: see the package's description.
        pose: Where the bodies stand [m, m, rad], shape ``(n_bodies, 3)``.
        rigid: The outlines follow from the poses; False where they are drawn anew for each level.
        radius: Radius of the moving body [m].
        start_x: Start [m].
        start_y: Start [m].
        goal_x: Goal [m].
        goal_y: Goal [m].
        tables: Of one slot; changed.
    """
    frame, blocked, runs, labels, known = tables
    origin_x, origin_y, cell = frame[0], frame[1], frame[2]
    stage = recall(known, outlines[7], pose, radius) if rigid else NEW
    if stage == NEW:
        ends = (start_x, start_y, goal_x, goal_y)
        return bool(is_reachable(*outlines, radius, *ends, origin_x, origin_y, cell, blocked, runs))
    if stage == SEEN:
        label_regions(outlines, radius, origin_x, origin_y, cell, blocked, runs, labels)
        known[0, 0] = LABELLED
    one = open_region(labels, start_x - origin_x, start_y - origin_y, cell)
    if one > 0 and one == open_region(labels, goal_x - origin_x, goal_y - origin_y, cell):
        return True
    if way_is_free(*outlines, radius, start_x, start_y, goal_x, goal_y):
        return True
    if not way_is_free(*outlines, radius, start_x, start_y, start_x, start_y):
        return False
    if not way_is_free(*outlines, radius, goal_x, goal_y, goal_x, goal_y):
        return False
    return bool(regions_meet(outlines, radius, start_x, start_y, goal_x, goal_y, origin_x, origin_y, cell, labels))


@kernel
def recall(known: Floats, blocks: Flags, pose: Floats, radius: float) -> float:
    """Return what is known about bodies that block as these do; note these if that is nothing."""
    same = known[0, 0] != NEW and known[0, 1] == radius
    for b in range(blocks.shape[0]):
        if not same:
            break
        if blocks[b]:
            x, y, heading = pose[b, 0], pose[b, 1], pose[b, 2]
            same = known[b + 1, 0] == 1.0 and known[b + 1, 1] == x and known[b + 1, 2] == y
            same = same and known[b + 1, 3] == heading
        else:
            same = known[b + 1, 0] == 0.0
    if same:
        return float(known[0, 0])
    known[0, 0], known[0, 1] = SEEN, radius
    for b in range(blocks.shape[0]):
        known[b + 1, 0] = 1.0 if blocks[b] else 0.0
        for axis in range(3):
            known[b + 1, 1 + axis] = pose[b, axis]
    return NEW


@kernel
def label_regions(
    outlines: Outlines,
    radius: float,
    origin_x: float,
    origin_y: float,
    cell: float,
    blocked: Bytes,
    runs: Ints,
    labels: Labels,
) -> None:
    """Write the region of each cell: 0 if it is blocked, positive if it is open, else negative.

    A cell is open if a disc of radius r + h / sqrt(2) about its centre touches nothing: then the body may stand
    anywhere in the cell, and go straight to its centre, so that start and goal in open cells of one region are joined.
    """
    mark_blocked(*outlines, radius, origin_x, origin_y, cell, blocked)
    count = join_runs(blocked, runs)
    columns = blocked.shape[1]
    labels[:] = 0
    for run in range(count):
        row = runs[run, KEY] // columns
        for column in range(runs[run, FIRST], runs[run, LAST] + 1):
            labels[row, column] = root(runs, run) + 1
    wide = radius + np.sqrt(0.5) * cell
    mark_blocked(*outlines, np.sqrt(wide * wide - 0.5 * cell * cell), origin_x, origin_y, cell, blocked)
    for row in range(blocked.shape[0]):
        for column in range(columns):
            if blocked[row, column] == BLOCKED:
                labels[row, column] = -labels[row, column]


@kernel
def open_region(labels: Labels, x: float, y: float, cell: float) -> int:
    """Return the region of the cell that holds a point (in the grid's frame) [m], at most 0 if it is not open."""
    row, column = np.floor(y / cell), np.floor(x / cell)
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
def regions_meet(
    outlines: Outlines,
    radius: float,
    start_x: float,
    start_y: float,
    goal_x: float,
    goal_y: float,
    origin_x: float,
    origin_y: float,
    cell: float,
    labels: Labels,
) -> bool:
    """Return whether free straight lines lead from start and goal to cells of one region, out of the 16 around each."""
    done = 0
    for i in range(16):
        row, column = gate(i, start_x - origin_x, start_y - origin_y, cell)
        one = region(labels, row, column)
        if one == 0 or one == done:
            continue
        x, y = origin_x + (column + 0.5) * cell, origin_y + (row + 0.5) * cell
        if not way_is_free(*outlines, radius, start_x, start_y, x, y):
            continue
        for j in range(16):
            row, column = gate(j, goal_x - origin_x, goal_y - origin_y, cell)
            if region(labels, row, column) == one:
                x, y = origin_x + (column + 0.5) * cell, origin_y + (row + 0.5) * cell
                if way_is_free(*outlines, radius, goal_x, goal_y, x, y):
                    return True
        done = one
    return False
