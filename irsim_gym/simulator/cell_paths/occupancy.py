"""Finds the cells of a grid that obstacles touch: as squares, not as discs about their centres as in ``grid``."""

import numpy as np

from irsim_gym.simulator.cell_maps.world_maps import map_of
from irsim_gym.simulator.geometry.polygons import holds_point
from irsim_gym.simulator.paths.clearance import Obstacles
from irsim_gym.simulator.world.names import BodyOutline, Cells, Flags, Point, kernel, outline_of

EDGE = 1e-9
"""Tolerance with which a shape that ends on a cell's edge touches the next cell, despite rounding [cells]."""


@kernel
def mark_touched(obstacles: Obstacles, x: float, y: float, width: float, height: float, touched: Flags) -> None:
    """Write which cells a body or an occupied cell of the map touches.

    A body touches the cells on whose edges it ends; a cell of the map has to overlap.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: touched.

    Args:
        obstacles: What is in the way.
        x: Left end of the grid [m].
        y: Lower end of the grid [m].
        width: Width of a cell [m].
        height: Height of a cell [m].
        touched: Written, shape ``(columns, rows)``.
    """
    touched[:] = False
    for b in range(obstacles.blocks.shape[0]):
        if not obstacles.blocks[b]:
            continue
        outline = outline_of(obstacles.model, obstacles.state, obstacles.w, b)
        segments, discs = outline.segments, outline.discs
        for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
            centre, radius = ((discs[d, 0] - x) / width, (discs[d, 1] - y) / height), discs[d, 2]
            touch_disc(centre, radius / width, radius / height, touched)
        for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
            begin = (segments[s, 0] - x) / width, (segments[s, 1] - y) / height
            end = (segments[s, 2] - x) / width, (segments[s, 3] - y) / height
            touch_segment(begin, end, touched)
        touch_inside(outline, x, y, width, height, touched)
    touch_cells(obstacles.cells, obstacles.w, x, y, width, height, touched)


@kernel
def touch_cells(cells: Cells, w: int, x: float, y: float, width: float, height: float, touched: Flags) -> None:
    """Mark the cells that an occupied cell of the map of world w overlaps."""
    if cells is None:
        return
    world_map = map_of(cells, w)
    boxes = world_map.boxes
    for k in range(world_map.n_boxes):
        left = (cells.x + boxes[k, 0] * cells.width - x) / width
        right = (cells.x + boxes[k, 1] * cells.width - x) / width
        low = (cells.y + boxes[k, 2] * cells.height - y) / height
        high = (cells.y + boxes[k, 3] * cells.height - y) / height
        if cells.radius == 0.0:
            touch_box((left, low), (right, high), touched)
            continue
        radius_x, radius_y = cells.radius / width, cells.radius / height
        for i in range(boxes[k, 0], boxes[k, 1]):
            for j in range(boxes[k, 2], boxes[k, 3]):
                cx, cy = cells.x + (i + 0.5) * cells.width, cells.y + (j + 0.5) * cells.height
                touch_disc(((cx - x) / width, (cy - y) / height), radius_x, radius_y, touched)


@kernel
def first_touched(low: float, count: int) -> int:
    """Return the first of ``count`` cells that something touches which begins at ``low`` (in cells)."""
    return int(max(min(np.floor(low - EDGE), float(count)), 0.0))


@kernel
def last_touched(high: float, count: int) -> int:
    """Return the last of ``count`` cells that something touches which ends at ``high`` (in cells), -1 for none."""
    return int(max(min(np.floor(high + EDGE), count - 1.0), -1.0))


@kernel
def touch_disc(centre: Point, radius_x: float, radius_y: float, touched: Flags) -> None:
    """Mark the cells that a disc touches; its radius in widths and in heights of a cell."""
    x, y = centre
    columns, rows = touched.shape
    for i in range(first_touched(x - radius_x, columns), last_touched(x + radius_x, columns) + 1):
        # The nearest point of the cell, in radii of the disc: cells need not be square.
        dx = max(i - x, x - i - 1.0, 0.0) / radius_x
        for j in range(first_touched(y - radius_y, rows), last_touched(y + radius_y, rows) + 1):
            dy = max(j - y, y - j - 1.0, 0.0) / radius_y
            if dx * dx + dy * dy <= 1.0 + EDGE:
                touched[i, j] = True


@kernel
def touch_segment(a: Point, b: Point, touched: Flags) -> None:
    """Mark the cells that a segment ab touches, by separating axes: the edges of the cell, and the segment."""
    ax, ay, bx, by = a[0], a[1], b[0], b[1]
    columns, rows = touched.shape
    # The segment's normal. The unit cell reaches half of |nx| + |ny| from its centre along it.
    across_x, across_y = ay - by, bx - ax
    length = np.sqrt(across_x * across_x + across_y * across_y)
    if length > 0.0:
        across_x, across_y = across_x / length, across_y / length
    reach = 0.5 * (abs(across_x) + abs(across_y)) + EDGE
    for i in range(first_touched(min(ax, bx), columns), last_touched(max(ax, bx), columns) + 1):
        for j in range(first_touched(min(ay, by), rows), last_touched(max(ay, by), rows) + 1):
            if abs(across_x * (i + 0.5 - ax) + across_y * (j + 0.5 - ay)) <= reach:
                touched[i, j] = True


@kernel
def touch_inside(outline: BodyOutline, x: float, y: float, width: float, height: float, touched: Flags) -> None:
    """Mark the cells within an outline, once those on its boundary are marked."""
    if not outline.solid or outline.n_segments == 0:
        return
    segments = outline.segments
    low_x, low_y, high_x, high_y = np.inf, np.inf, -np.inf, -np.inf
    for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
        low_x, high_x = min(low_x, segments[s, 0]), max(high_x, segments[s, 0])
        low_y, high_y = min(low_y, segments[s, 1]), max(high_y, segments[s, 1])
    columns, rows = touched.shape
    first, last = first_touched((low_x - x) / width, columns), last_touched((high_x - x) / width, columns)
    low, high = first_touched((low_y - y) / height, rows), last_touched((high_y - y) / height, rows)
    for i in range(first, last + 1):
        for j in range(low, high + 1):
            if not touched[i, j]:
                touched[i, j] = holds_point(outline, (x + (i + 0.5) * width, y + (j + 0.5) * height))


@kernel
def touch_box(lower_left: Point, upper_right: Point, touched: Flags) -> None:
    """Mark the cells that an upright box overlaps."""
    left, low, right, high = lower_left[0], lower_left[1], upper_right[0], upper_right[1]
    columns, rows = touched.shape
    # Twice the tolerance inwards: a box that only ends on a cell's edge does not overlap the cell.
    for i in range(first_touched(left + 2.0 * EDGE, columns), last_touched(right - 2.0 * EDGE, columns) + 1):
        for j in range(first_touched(low + 2.0 * EDGE, rows), last_touched(high - 2.0 * EDGE, rows) + 1):
            touched[i, j] = True
