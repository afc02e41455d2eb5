"""Paths around everything that a body's scans have shown so far; unseen space counts as free."""

from typing import NamedTuple, Self

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Labels, Point
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.cell_paths.cell_lines import free_cell, is_clear
from irsim_gym.simulator.paths.grid import BLOCKED, FREE, Grid, Search, centre
from irsim_gym.simulator.paths.spread import PARENT, clear_field, offer, spread


class SeenCells(NamedTuple):
    """Steps of the episode, counted from 1, in which cells were last found blocked; 0 for never.

    Attributes:
        hard: A body at the cell's centre would collide, shape ``(n_worlds, n_members, rows, columns)``.
        soft: A body at the cell's centre would be closer than its distance, same shape as ``hard``.
    """

    hard: Labels
    soft: Labels

    @classmethod
    def reserve(cls, n_worlds: int, n_members: int, grid: Grid) -> Self:
        """Allocate memory for the members of a group that has seen nothing yet."""
        shape = (n_worlds, n_members, grid.rows, grid.columns)
        return cls(np.zeros(shape, np.int32), np.zeros(shape, np.int32))


@kernel
def note_hit(
    x: float, y: float, reach: float, distance: float, grid: Grid, now: int, hard: Labels, soft: Labels
) -> None:
    """Mark the cells that are too close to a point that a beam hit.

    Writes: hard, soft.

    Args:
        x: X coordinate of the point [m].
        y: Y coordinate of the point [m].
        reach: Radius of the body [m].
        distance: Distance that the body's surface has to keep [m].
        grid: The grid.
        now: Current step.
        hard: ``SeenCells.hard`` of one member.
        soft: ``SeenCells.soft`` of one member.
    """
    far = reach + distance
    # In cells from the centre of cell 0, which is half a cell inside of the grid's corner.
    column, row = (x - grid.origin_x) / grid.cell - 0.5, (y - grid.origin_y) / grid.cell - 0.5
    half = far / grid.cell
    for i in range(max(int(np.ceil(row - half)), 0), min(int(np.floor(row + half)) + 1, grid.rows)):
        for j in range(max(int(np.ceil(column - half)), 0), min(int(np.floor(column + half)) + 1, grid.columns)):
            dx, dy = (j - column) * grid.cell, (i - row) * grid.cell
            distance2 = dx * dx + dy * dy
            if distance2 <= far * far:
                soft[i, j] = now
            if distance2 <= reach * reach:
                hard[i, j] = now


@kernel
def find_seen_way(
    start: Point, goal: Point, grid: Grid, seen: Labels, oldest: int, search: Search, path: Floats
) -> int:
    """Write a short path over cells that are not known to be blocked; return its number of points, 0 if there is none.

    Writes: search, path.

    Args:
        start: Start of the path [m]; if its cell is blocked, the path begins with a free cell near it.
        goal: End of the path [m]; likewise.
        grid: The grid.
        seen: Step in which each cell was last found blocked, shape ``(rows, columns)``.
        oldest: Cells found blocked in this step or earlier count as free again.
        search: Scratch.
        path: Written: points [m], shape ``(n_cells + 64, 2)``.
    """
    blocked = search.blocked
    for i in range(grid.rows):
        for j in range(grid.columns):
            blocked[i, j] = BLOCKED if seen[i, j] > oldest else FREE
    cell, there = free_cell(grid, blocked, start), free_cell(grid, blocked, goal)
    if cell < 0 or there < 0:
        return 0
    clear_field(search)
    # The search begins at the goal: parents then lead from the body to the goal, in order.
    offer(search.field.reshape(-1), search.queue, there, 0.0, -1, grid.cell)
    spread(grid.cell, cell, np.inf, search)
    if not search.field[cell // grid.columns, cell % grid.columns] < np.inf:
        return 0
    path[0, 0], path[0, 1], count = start[0], start[1], 1
    # The goal's cell has the parent -1.
    while cell >= 0:
        path[count, 0], path[count, 1] = centre(grid, cell // grid.columns, cell % grid.columns)
        cell, count = search.queue[PARENT, cell], count + 1
    path[count, 0], path[count, 1] = goal[0], goal[1]
    return straighten(path, count + 1, grid, blocked)


@kernel
def straighten(path: Floats, count: int, grid: Grid, blocked: Bytes) -> int:
    """Remove the points of a path that a straight line over free cells can skip; return how many are left.

    Writes: path.
    """
    length, i = 1, 0
    while i < count - 1:
        last = i + 1
        # The farthest point that can be seen from the last one kept; the next one always can.
        for j in range(count - 1, i + 1, -1):
            if is_clear((path[length - 1, 0], path[length - 1, 1]), (path[j, 0], path[j, 1]), grid, blocked):
                last = j
                break
        path[length, 0], path[length, 1] = path[last, 0], path[last, 1]
        length, i = length + 1, last
    return length


@kernel
def is_still_free(points: Floats, first: int, count: int, grid: Grid, seen: Labels, oldest: int) -> bool:
    """Return whether a path, from point ``first`` on, crosses no cell that has been found blocked."""
    for s in range(first, count - 1):
        ax, ay, dx, dy = points[s, 0], points[s, 1], points[s + 1, 0] - points[s, 0], points[s + 1, 1] - points[s, 1]
        # Samples at most half a cell apart.
        parts = int(np.ceil(2.0 * np.sqrt(dx * dx + dy * dy) / grid.cell)) + 1
        for i in range(parts):
            column = int(np.floor((ax + dx * i / parts - grid.origin_x) / grid.cell))
            row = int(np.floor((ay + dy * i / parts - grid.origin_y) / grid.cell))
            if 0 <= row < grid.rows and 0 <= column < grid.columns and seen[row, column] > oldest:
                return False
    return True
