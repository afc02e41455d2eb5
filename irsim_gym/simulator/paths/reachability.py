"""Tests whether a path exists for a disc between two points."""

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Ints, Point
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.paths.clearance import Obstacles, way_is_free
from irsim_gym.simulator.paths.grid import BLOCKED, Grid, centre, mark_blocked

FIRST, LAST, PARENT, KEY = 0, 1, 2, 3
"""Columns of a table of runs, see ``join_runs``."""


@kernel
def is_reachable(
    obstacles: Obstacles, radius: float, start: Point, goal: Point, grid: Grid, blocked: Bytes, runs: Ints
) -> bool:
    """Return whether a disc has a free path from start to goal within the grid.

    True is a proof: the straight path is free, or a path leads through free cells (see ``grid``) and enters and leaves
    them on straight lines that are tested exactly. False may be wrong if every path leads through a gap that is less
    than about 2 sqrt(r^2 + h^2 / 2) - 2 r + sqrt(2) h wider than the disc, where h is the side of a cell.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: blocked, runs.

    Args:
        obstacles: What is in the way.
        radius: Radius of the moving body [m].
        start: Where it starts [m].
        goal: Where it goes [m].
        grid: The grid.
        blocked: Scratch, shape ``(rows, columns)``; holds the blocked cells afterwards if the way is not straight.
        runs: Scratch, shape ``(n_runs, 4)``, as from ``Grid.runs``.
    """
    if way_is_free(obstacles, radius, start, goal):
        return True
    if not way_is_free(obstacles, radius, start, start) or not way_is_free(obstacles, radius, goal, goal):
        return False
    mark_blocked(obstacles, radius, grid, blocked)
    count = join_runs(blocked, runs)
    for i in range(16):
        row, column = gate(i, start, grid)
        run = find_run(runs, count, blocked, row, column)
        if run >= 0 and runs[run, KEY] >= 0 and way_is_free(obstacles, radius, start, centre(grid, row, column)):
            # -1 - key marks a region without losing the key, 0 included.
            runs[run, KEY] = -1 - runs[run, KEY]
    for i in range(16):
        row, column = gate(i, goal, grid)
        run = find_run(runs, count, blocked, row, column)
        if run >= 0 and runs[run, KEY] < 0 and way_is_free(obstacles, radius, goal, centre(grid, row, column)):
            return True
    return False


@kernel
def gate(i: int, point: Point, grid: Grid) -> tuple[int, int]:
    """Return row and column of the i-th of the 16 cells whose centres surround a point [m].

    The four nearest come first; cells may lie outside of the grid.
    """
    column = int(np.floor((point[0] - grid.origin_x) / grid.cell - 0.5))
    row = int(np.floor((point[1] - grid.origin_y) / grid.cell - 0.5))
    # The square of 2 x 2 centres around the point; then the columns beside it; then the rows of four below and above.
    if i < 4:
        return row + i // 2, column + i % 2
    if i < 8:
        return row + (i - 4) // 2, column - 1 + 3 * (i % 2)
    return row - 1 + 3 * (i // 12), column - 1 + i % 4


@kernel
def join_runs(blocked: Bytes, runs: Ints) -> int:
    """Write the runs of free cells of all rows, joined where they touch (corners included), and return their number.

    A run has its FIRST and LAST column, a PARENT in the forest of joined runs and as KEY the number of its first cell.
    """
    columns = blocked.shape[1]
    count, before = 0, 0
    for row in range(blocked.shape[0]):
        begin, column = count, 0
        while column < columns:
            if blocked[row, column] == BLOCKED:
                column += 1
                continue
            runs[count, FIRST], runs[count, PARENT], runs[count, KEY] = column, count, row * columns + column
            while column < columns and blocked[row, column] != BLOCKED:
                column += 1
            runs[count, LAST] = column - 1
            # Both rows are walked from left to right: runs of the row before that end too early are done with.
            while before < begin and runs[before, LAST] < runs[count, FIRST] - 1:
                before += 1
            other = before
            # One more at either end lets runs touch at a corner. The last of these may touch the next run as well.
            while other < begin and runs[other, FIRST] <= runs[count, LAST] + 1:
                join(runs, other, count)
                other += 1
            count += 1
        before = begin
    return count


@kernel
def root(runs: Ints, run: int) -> int:
    """Return the run that represents all runs joined with this one."""
    while runs[run, PARENT] != run:
        # Path halving: every second run on the way to the root skips its parent.
        runs[run, PARENT] = runs[runs[run, PARENT], PARENT]
        run = runs[run, PARENT]
    return run


@kernel
def join(runs: Ints, first: int, other: int) -> None:
    """Join two runs. The one with the lower index represents both."""
    first, other = root(runs, first), root(runs, other)
    runs[max(first, other), PARENT] = min(first, other)


@kernel
def find_run(runs: Ints, count: int, blocked: Bytes, row: int, column: int) -> int:
    """Return the representative of the run that holds a cell, -1 if the cell is blocked or outside the grid.

    A negative KEY marks a run that can be reached from the start.
    """
    rows, columns = blocked.shape
    if row < 0 or column < 0 or row >= rows or column >= columns or blocked[row, column] == BLOCKED:
        return -1
    key, low, high = row * columns + column, 0, count
    # Bisection: runs are in the order of their first cells. The cell is not blocked, so the last run that begins at or
    # before it holds it.
    while high - low > 1:
        middle = (low + high) // 2
        begin = runs[middle, KEY]
        if (begin if begin >= 0 else -1 - begin) <= key:
            low = middle
        else:
            high = middle
    return root(runs, low)
