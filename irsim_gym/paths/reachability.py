"""Is there a way for a body between two points?"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Bytes, CellMap, Flags, Floats, Ints
from irsim_gym.jit import kernel
from irsim_gym.paths.clearance import way_is_free
from irsim_gym.paths.grid import BLOCKED, mark_blocked

FIRST, LAST, PARENT, KEY = 0, 1, 2, 3


@kernel
def is_reachable(
    segments: Floats,
    segment_start: Ints,
    segment_count: Ints,
    discs: Floats,
    disc_start: Ints,
    disc_count: Ints,
    solid: Flags,
    blocks: Flags,
    cells: CellMap | None,
    radius: float,
    start_x: float,
    start_y: float,
    goal_x: float,
    goal_y: float,
    origin_x: float,
    origin_y: float,
    cell: float,
    blocked: Bytes,
    runs: Ints,
) -> bool:
    """Return whether a body of some radius has a free way from start to goal within the grid.

    True is a proof: the way is straight, or leads through cells that are free (see ``grid``), which it enters and
    leaves on straight lines that were tested exactly. False may be wrong where the only way leads through a gap less
    than about 2 sqrt(r^2 + h^2 / 2) - 2 r + sqrt(2) h wider than the body, with the side h of a cell.

    Args:
        segments: As all tables up to ``cells``: see the package's description.
        segment_start: See there.
        segment_count: See there.
        discs: See there.
        disc_start: See there.
        disc_count: See there.
        solid: See there.
        blocks: See there.
        cells: See there.
        radius: Radius of the moving body [m].
        start_x: Start [m].
        start_y: Start [m].
        goal_x: Goal [m].
        goal_y: Goal [m].
        origin_x: Lower left corner of the grid [m].
        origin_y: Lower left corner of the grid [m].
        cell: Side of a cell [m].
        blocked: Scratch, shape ``(rows, columns)``; holds the blocked cells afterwards if the way is not straight.
        runs: Scratch, shape ``(n_runs, 4)``, as from ``Grid.runs``.
    """
    outlines = (segments, segment_start, segment_count, discs, disc_start, disc_count, solid, blocks, cells)
    if way_is_free(*outlines, radius, start_x, start_y, goal_x, goal_y):
        return True
    if not way_is_free(*outlines, radius, start_x, start_y, start_x, start_y):
        return False
    if not way_is_free(*outlines, radius, goal_x, goal_y, goal_x, goal_y):
        return False
    mark_blocked(*outlines, radius, origin_x, origin_y, cell, blocked)
    count = join_runs(blocked, runs)
    for i in range(16):
        row, column = gate(i, start_x - origin_x, start_y - origin_y, cell)
        run = find_run(runs, count, blocked, row, column)
        if run >= 0 and runs[run, KEY] >= 0:
            x, y = origin_x + (column + 0.5) * cell, origin_y + (row + 0.5) * cell
            if way_is_free(*outlines, radius, start_x, start_y, x, y):
                runs[run, KEY] = -1 - runs[run, KEY]
    for i in range(16):
        row, column = gate(i, goal_x - origin_x, goal_y - origin_y, cell)
        run = find_run(runs, count, blocked, row, column)
        if run >= 0 and runs[run, KEY] < 0:
            x, y = origin_x + (column + 0.5) * cell, origin_y + (row + 0.5) * cell
            if way_is_free(*outlines, radius, goal_x, goal_y, x, y):
                return True
    return False


@kernel
def gate(i: int, x: float, y: float, cell: float) -> tuple[int, int]:
    """Return row and column of the i-th of the 16 cells whose centres surround a point (in the grid's frame) [m].

    The four nearest come first; cells may lie outside of the grid.
    """
    column, row = int(np.floor(x / cell - 0.5)), int(np.floor(y / cell - 0.5))
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
            while before < begin and runs[before, LAST] < runs[count, FIRST] - 1:
                before += 1
            other = before
            while other < begin and runs[other, FIRST] <= runs[count, LAST] + 1:
                join(runs, other, count)
                other += 1
            count += 1
        before = begin
    return count


@kernel
def root(runs: Ints, run: int) -> int:
    """Return the run that stands for all joined with this one."""
    while runs[run, PARENT] != run:
        runs[run, PARENT] = runs[runs[run, PARENT], PARENT]
        run = runs[run, PARENT]
    return run


@kernel
def join(runs: Ints, one: int, other: int) -> None:
    """Join two runs; the lower number stands for both."""
    one, other = root(runs, one), root(runs, other)
    runs[max(one, other), PARENT] = min(one, other)


@kernel
def find_run(runs: Ints, count: int, blocked: Bytes, row: int, column: int) -> int:
    """Return what stands for the run that holds a cell, -1 for a cell that is blocked or outside of the grid.

    A negative KEY is the mark of a run from which the start can be reached.
    """
    rows, columns = blocked.shape
    if row < 0 or column < 0 or row >= rows or column >= columns or blocked[row, column] == BLOCKED:
        return -1
    key, low, high = row * columns + column, 0, count
    while high - low > 1:
        middle = (low + high) // 2
        begin = runs[middle, KEY]
        if (begin if begin >= 0 else -1 - begin) <= key:
            low = middle
        else:
            high = middle
    return root(runs, low)
