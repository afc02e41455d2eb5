"""Ways around what the scans of a body have shown so far; what it has not seen counts as free."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np

from irsim_gym.arraytypes import Bytes, Floats, Labels, Point
from irsim_gym.jit import kernel
from irsim_gym.paths.cell_lines import free_cell, is_clear
from irsim_gym.paths.grid import BLOCKED, FREE, Grid, Search, centre
from irsim_gym.paths.spread import PARENT, clear_field, offer, spread


class SeenCells(NamedTuple):
    """When cells were last found to be too near to something, in steps of the episode from 1 on; 0: never.

    Attributes:
        hard: The body touches something at the cell's centre, shape ``(n_worlds, n_members, rows, columns)``.
        soft: It does not keep its distance there, shaped as ``hard``.
    """

    hard: Labels
    soft: Labels

    @classmethod
    def reserve(cls, n_worlds: int, n_members: int, grid: Grid) -> Self:
        """Return memory for the members of a group that has seen nothing."""
        shape = (n_worlds, n_members, grid.rows, grid.columns)
        return cls(np.zeros(shape, np.int32), np.zeros(shape, np.int32))


@kernel
def note_hit(
    x: float, y: float, reach: float, distance: float, grid: Grid, now: int, hard: Labels, soft: Labels
) -> None:
    """Write which cells are too near to a point that was hit.

    Writes: hard, soft.

    Args:
        x: The point [m].
        y: The point [m].
        reach: Radius of the body [m].
        distance: How far its surface is to keep [m].
        grid: The grid.
        now: The step.
        hard: See ``SeenCells``, of one member.
        soft: Likewise.
    """
    far = reach + distance
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
    """Write a short way over cells that are free as far as is known; return its number of points, 0 without one.

    Writes: search, path.

    Args:
        start: Where it begins [m]; beside a free cell, if its own is none.
        goal: Where it leads [m], likewise.
        grid: The grid.
        seen: When cells were last found blocked, shape ``(rows, columns)``.
        oldest: What was found earlier is forgotten.
        search: Scratch.
        path: Written: points [m], shape ``(n_cells + 64, 2)``.
    """
    blocked = search.blocked
    for i in range(grid.rows):
        for j in range(grid.columns):
            blocked[i, j] = BLOCKED if seen[i, j] > oldest else FREE
    here, there = free_cell(grid, blocked, start), free_cell(grid, blocked, goal)
    if here < 0 or there < 0:
        return 0
    clear_field(search)
    offer(search.field.reshape(-1), search.queue, there, 0.0, -1, grid.cell)
    spread(grid.cell, here, search)
    if not search.field[here // grid.columns, here % grid.columns] < np.inf:
        return 0
    path[0, 0], path[0, 1], count = start[0], start[1], 1
    while here >= 0:
        path[count, 0], path[count, 1] = centre(grid, here // grid.columns, here % grid.columns)
        here, count = search.queue[PARENT, here], count + 1
    path[count, 0], path[count, 1] = goal[0], goal[1]
    return straighten(path, count + 1, grid, blocked)


@kernel
def straighten(path: Floats, count: int, grid: Grid, blocked: Bytes) -> int:
    """Leave out points of a path that can be passed by straight over free cells; return how many are left.

    Writes: path.
    """
    kept, i = 1, 0
    while i < count - 1:
        last = i + 1
        for j in range(count - 1, i + 1, -1):
            if is_clear((path[kept - 1, 0], path[kept - 1, 1]), (path[j, 0], path[j, 1]), grid, blocked):
                last = j
                break
        path[kept, 0], path[kept, 1] = path[last, 0], path[last, 1]
        kept, i = kept + 1, last
    return kept


@kernel
def is_still_free(points: Floats, first: int, count: int, grid: Grid, seen: Labels, oldest: int) -> bool:
    """Return whether the sides of a path from one on lead over no cell that has been found blocked."""
    for s in range(first, count - 1):
        ax, ay, dx, dy = points[s, 0], points[s, 1], points[s + 1, 0] - points[s, 0], points[s + 1, 1] - points[s, 1]
        parts = int(np.ceil(2.0 * np.sqrt(dx * dx + dy * dy) / grid.cell)) + 1
        for i in range(parts):
            column = int(np.floor((ax + dx * i / parts - grid.origin_x) / grid.cell))
            row = int(np.floor((ay + dy * i / parts - grid.origin_y) / grid.cell))
            if 0 <= row < grid.rows and 0 <= column < grid.columns and seen[row, column] > oldest:
                return False
    return True
