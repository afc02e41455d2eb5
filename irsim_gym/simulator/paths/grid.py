"""A grid of free space.

A cell of side h is free if a disc of radius R = sqrt(r^2 + h^2 / 2) about its centre touches nothing. Then a body of
radius r can go straight between the centres of two free cells that share a side or a corner, and through every
triangle of three free centres of a square of four:

Let o be a point of an obstacle, c_i the centres and x = sum l_i c_i a point between them (l_i >= 0, sum l_i = 1).
Expanding the squares gives sum l_i |o - c_i|^2 = |o - x|^2 + sum l_i |x - c_i|^2. The left side is more than R^2. The
last sum equals q^2 - |x - m|^2 with the centre m and radius q of the circle through the c_i (for two of them, the
circle on their distance), and q^2 <= h^2 / 2. Hence |o - x|^2 > R^2 - h^2 / 2 = r^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np

from irsim_gym.simulator.cell_maps.world_maps import map_of
from irsim_gym.simulator.geometry.polygons import holds_point
from irsim_gym.simulator.paths.clearance import Obstacles
from irsim_gym.simulator.paths.points import BLOCK, PointMap
from irsim_gym.simulator.world.names import BodyOutline, Bytes, Cells, Floats, Ints, Point, kernel, outline_of

FREE, BLOCKED = np.uint8(0), np.uint8(1)
"""Whether a cell is blocked."""
MOST_PATH_CELLS = 1_000_000
"""Maximum number of cells of a grid."""
CELL_MARGIN = 1e-9
"""Safety margin added to the radius of cells, so that rounding never frees one [m]."""


class Grid(NamedTuple):
    """Square cells over a rectangle, with all centres inside it.

    Attributes:
        origin_x: Lower left corner of the first cell [m].
        origin_y: Lower left corner of the first cell [m].
        cell: Side of a cell [m].
        columns: Number of cells along x.
        rows: Number of cells along y.
    """

    origin_x: float
    origin_y: float
    cell: float
    columns: int
    rows: int

    @classmethod
    def over(cls, bounds: Sequence[float] | Floats, cell: float) -> Self:
        """Return the grid over x_min, y_min, x_max, y_max [m], centred in the rectangle.

        Cells are larger than requested if there would be more than ``MOST_PATH_CELLS`` of them.
        """
        x_min, y_min, x_max, y_max = (float(value) for value in bounds)
        cell = max(cell, float(np.sqrt((x_max - x_min) * (y_max - y_min) / MOST_PATH_CELLS)))
        columns = max(1, round((x_max - x_min) / cell))
        rows = max(1, round((y_max - y_min) / cell))
        origin_x = 0.5 * (x_min + x_max - columns * cell)
        origin_y = 0.5 * (y_min + y_max - rows * cell)
        return cls(origin_x, origin_y, float(cell), columns, rows)

    def blocked(self) -> Bytes:
        """Return memory for ``mark_blocked``, shape ``(rows, columns)``."""
        return np.zeros((self.rows, self.columns), np.uint8)

    def runs(self) -> Ints:
        """Return scratch memory for ``is_reachable``, shape ``(n_runs, 4)``."""
        # A row of n cells has (n + 1) // 2 runs at most: free and blocked cells in turn.
        return np.zeros((self.rows * ((self.columns + 1) // 2), 4), np.int64)

    def search(self) -> Search:
        """Return memory for a search."""
        n_cells, shape = self.rows * self.columns, (self.rows, self.columns)
        # 8 more: each of them is the beginning or the end of a list, see spread.
        return Search(np.zeros(shape, np.uint8), np.zeros(shape), np.zeros((3, n_cells + 8), np.int64))

    def path(self) -> Floats:
        """Return memory for ``shortest_path``, shape ``(n_points, 2)``."""
        # Every cell, both ends, and some points that `pull` adds.
        return np.zeros((self.rows * self.columns + 64, 2))


class Search(NamedTuple):
    """Memory of a search over the cells of a grid.

    Attributes:
        blocked: Blocked cells, shape ``(rows, columns)``.
        field: Distance to the nearest source [m], inf without a path, shape ``(rows, columns)``.
        queue: The queue, and in row PARENT the number of the next cell on the path to the source, -1 beside it; shape
            ``(3, n_cells + 8)``, see ``spread``.
    """

    blocked: Bytes
    field: Floats
    queue: Ints


@kernel
def centre(grid: Grid, row: int, column: int) -> Point:
    """Return the centre of a cell [m]."""
    return grid.origin_x + (column + 0.5) * grid.cell, grid.origin_y + (row + 0.5) * grid.cell


@kernel
def mark_blocked(obstacles: Obstacles, radius: float, grid: Grid, blocked: Bytes) -> None:
    """Write which cells are blocked for a body of some radius.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: blocked.

    Args:
        obstacles: What is in the way.
        radius: Radius r of the moving body [m].
        grid: The grid.
        blocked: Written: 1 where a disc of radius R about the cell's centre touches a body, shape ``(rows, columns)``.
    """
    blocked[:] = FREE
    blocks, cell = obstacles.blocks, grid.cell
    wide = np.sqrt(radius * radius + 0.5 * grid.cell * grid.cell) + CELL_MARGIN
    for b in range(blocks.shape[0]):
        if not blocks[b]:
            continue
        outline = outline_of(obstacles.model, obstacles.state, obstacles.w, b)
        segments, discs = outline.segments, outline.discs
        for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
            x, y = discs[d, 0] - grid.origin_x, discs[d, 1] - grid.origin_y
            block_capsule(x, y, x, y, discs[d, 2] + wide, cell, blocked)
        for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
            ax, ay = segments[s, 0] - grid.origin_x, segments[s, 1] - grid.origin_y
            bx, by = segments[s, 2] - grid.origin_x, segments[s, 3] - grid.origin_y
            block_capsule(ax, ay, bx, by, wide, cell, blocked)
    # After all boundaries, which separate the runs of cells inside and outside.
    for b in range(blocks.shape[0]):
        if blocks[b]:
            block_inside(outline_of(obstacles.model, obstacles.state, obstacles.w, b), grid, blocked)
    block_around_cells(obstacles.cells, obstacles.w, wide, grid, blocked)
    block_around_points(obstacles.points, wide, grid, blocked)


@kernel
def block_around_cells(cells: Cells, w: int, radius: float, grid: Grid, blocked: Bytes) -> None:
    """Block the cells whose centres lie within ``radius`` [m] of an occupied cell of the map of world w."""
    if cells is None:
        return
    world_map, x, y = map_of(cells, w), cells.x - grid.origin_x, cells.y - grid.origin_y
    boxes = world_map.boxes
    for k in range(world_map.n_boxes):
        left, right = x + boxes[k, 0] * cells.width, x + boxes[k, 1] * cells.width
        low, high = y + boxes[k, 2] * cells.height, y + boxes[k, 3] * cells.height
        if cells.radius > 0.0:
            for i in range(boxes[k, 0], boxes[k, 1]):
                for j in range(boxes[k, 2], boxes[k, 3]):
                    cx, cy = x + (i + 0.5) * cells.width, y + (j + 0.5) * cells.height
                    block_capsule(cx, cy, cx, cy, radius + cells.radius, grid.cell, blocked)
            continue
        block_box(left, low, right, high, radius, grid.cell, blocked)


@kernel
def block_around_points(points: PointMap | None, radius: float, grid: Grid, blocked: Bytes) -> None:
    """Block the cells whose centres lie within ``radius`` [m] of a point."""
    if points is None:
        return
    places = points.places
    for i in range(places.shape[0]):
        for j in range(places.shape[1]):
            if points.filled[i, j // BLOCK] == 0:
                continue
            x, y = float(places[i, j, 0]) - grid.origin_x, float(places[i, j, 1]) - grid.origin_y
            if x == x:
                block_capsule(x, y, x, y, radius, grid.cell, blocked)


@kernel
def block_box(left: float, low: float, right: float, high: float, radius: float, cell: float, blocked: Bytes) -> None:
    """Block the cells whose centres lie within ``radius`` of an upright box (in the grid's frame) [m]."""
    rows, columns = blocked.shape
    for row in range(first_cell(low - radius, cell, rows), last_cell(high + radius, cell, rows) + 1):
        y = (row + 0.5) * cell
        aside = max(low - y, y - high, 0.0)
        # Rows above and below the box reach less far beyond its sides: the corners of the grown box are round.
        half = np.sqrt(max(radius * radius - aside * aside, 0.0))
        for column in range(first_cell(left - half, cell, columns), last_cell(right + half, cell, columns) + 1):
            blocked[row, column] = BLOCKED


@kernel
def first_cell(coordinate: float, cell: float, count: int) -> int:
    """Return the first of ``count`` cells whose centre is not before a coordinate [m], ``count`` if there is none."""
    return int(max(min(np.ceil(coordinate / cell - 0.5), float(count)), 0.0))


@kernel
def last_cell(coordinate: float, cell: float, count: int) -> int:
    """Return the last of ``count`` cells whose centre is not beyond a coordinate [m], -1 if there is none."""
    return int(max(min(np.floor(coordinate / cell - 0.5), count - 1.0), -1.0))


@kernel
def block_capsule(ax: float, ay: float, bx: float, by: float, radius: float, cell: float, blocked: Bytes) -> None:
    """Block the cells whose centres lie within ``radius`` of the segment ab (in the grid's frame) [m].

    In each row these lie in one interval: what the discs about both ends and the rectangle between them cover.
    """
    dx, dy = bx - ax, by - ay
    length = np.sqrt(dx * dx + dy * dy)
    along_x, along_y = (dx / length, dy / length) if length > 0.0 else (1.0, 0.0)
    rows, columns = blocked.shape
    top = last_cell(max(ay, by) + radius, cell, rows)
    for row in range(first_cell(min(ay, by) - radius, cell, rows), top + 1):
        y = (row + 0.5) * cell
        left, right = np.inf, -np.inf
        room_a, room_b = radius * radius - (y - ay) * (y - ay), radius * radius - (y - by) * (y - by)
        if room_a >= 0.0:
            half = np.sqrt(room_a)
            left, right = ax - half, ax + half
        if room_b >= 0.0:
            half = np.sqrt(room_b)
            left, right = min(left, bx - half), max(right, bx + half)
        # The rectangle: x whose projection on ab is from 0 to its length, and whose distance from its line is small.
        near, far = band(y - ay, along_x, along_y, 0.0, length)
        near_side, far_side = band(y - ay, -along_y, along_x, -radius, radius)
        near, far = max(near, near_side), min(far, far_side)
        if near <= far:
            left, right = min(left, ax + near), max(right, ax + far)
        for column in range(first_cell(left, cell, columns), last_cell(right, cell, columns) + 1):
            blocked[row, column] = BLOCKED


@kernel
def band(y: float, slope_x: float, slope_y: float, low: float, high: float) -> tuple[float, float]:
    """Return the interval of x where low <= slope_x x + slope_y y <= high; empty if its ends are swapped."""
    rest = slope_y * y
    if slope_x > 0.0:
        return (low - rest) / slope_x, (high - rest) / slope_x
    if slope_x < 0.0:
        return (high - rest) / slope_x, (low - rest) / slope_x
    if low <= rest <= high:
        return -np.inf, np.inf
    return np.inf, -np.inf


@kernel
def block_inside(outline: BodyOutline, grid: Grid, blocked: Bytes) -> None:
    """Block the cells within an outline, once the cells around its segments are blocked.

    Between neighbours of which one lies inside and one outside, one is nearer to the boundary than h and blocked, so
    each run of free cells in a row lies on one side and one test is enough for it.
    """
    if not outline.solid or outline.n_segments == 0:
        return
    segments, cell = outline.segments, grid.cell
    low_x, low_y, high_x, high_y = np.inf, np.inf, -np.inf, -np.inf
    for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
        low_x, high_x = min(low_x, segments[s, 0]), max(high_x, segments[s, 0])
        low_y, high_y = min(low_y, segments[s, 1]), max(high_y, segments[s, 1])
    rows, columns = blocked.shape
    first, last = first_cell(low_x - grid.origin_x, cell, columns), last_cell(high_x - grid.origin_x, cell, columns)
    top = last_cell(high_y - grid.origin_y, cell, rows)
    for row in range(first_cell(low_y - grid.origin_y, cell, rows), top + 1):
        tested, inside = False, False
        for column in range(first, last + 1):
            if blocked[row, column] == BLOCKED:
                tested = False
                continue
            if not tested:
                x, y = centre(grid, row, column)
                tested, inside = True, holds_point(outline, (x, y))
            if inside:
                blocked[row, column] = BLOCKED
