"""Straight lines over the cells of a grid, and the cell at which a path over cells begins."""

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Point
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.paths.grid import BLOCKED, FREE, Grid

NEAR = 15
"""Search radius around a point for a cell that is not blocked [cells]."""


@kernel
def free_cell(grid: Grid, blocked: Bytes, place: Point) -> int:
    """Return the number of the cell that is not blocked and whose centre is nearest to a point, -1 if none is near."""
    # In cells from the centre of cell 0, so that whole numbers are centres; rounding half down finds the own cell.
    column, row = (place[0] - grid.origin_x) / grid.cell - 0.5, (place[1] - grid.origin_y) / grid.cell - 0.5
    best, cell = np.inf, -1
    own_row, own_column = int(np.ceil(row - 0.5)), int(np.ceil(column - 0.5))
    is_inside = 0 <= own_row < grid.rows and 0 <= own_column < grid.columns
    if is_inside and blocked[own_row, own_column] != BLOCKED:
        return own_row * grid.columns + own_column
    for i in range(max(own_row - NEAR, 0), min(own_row + NEAR + 1, grid.rows)):
        for j in range(max(own_column - NEAR, 0), min(own_column + NEAR + 1, grid.columns)):
            distance2 = (i - row) * (i - row) + (j - column) * (j - column)
            if blocked[i, j] != BLOCKED and distance2 < best:
                best, cell = distance2, i * grid.columns + j
    return cell


@kernel
def is_clear(start: Point, end: Point, grid: Grid, blocked: Bytes) -> bool:
    """Return whether all points at every half cell between two points [m] lie in free cells or outside of the grid.

    Cells that are neither free nor blocked (see ``wavefront``) count as free up to the first one that is free.
    """
    dx, dy, was_free = end[0] - start[0], end[1] - start[1], False
    # Both ends are left out: they are points of the path already, or may lie in blocked cells.
    parts = int(np.ceil(2.0 * np.sqrt(dx * dx + dy * dy) / grid.cell))
    for i in range(1, parts):
        column = int(np.floor((start[0] + dx * i / parts - grid.origin_x) / grid.cell))
        row = int(np.floor((start[1] + dy * i / parts - grid.origin_y) / grid.cell))
        if 0 <= row < grid.rows and 0 <= column < grid.columns:
            if blocked[row, column] == FREE:
                was_free = True
            elif was_free or blocked[row, column] == BLOCKED:
                return False
    return True
