"""Which cells of a grid something touches: the squares themselves, not discs about their centres as in ``grid``."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import CellMap, Flags, Floats, Ints
from irsim_gym.geometry.polygons import contains_point
from irsim_gym.jit import kernel

EDGE = 1e-9
"""Parts of a cell by which what ends on a cell's edge touches the cell behind it, in spite of rounding."""


@kernel
def mark_touched(
    segments: Floats,
    segment_start: Ints,
    segment_count: Ints,
    discs: Floats,
    disc_start: Ints,
    disc_count: Ints,
    solid: Flags,
    blocks: Flags,
    cells: CellMap | None,
    origin_x: float,
    origin_y: float,
    cell_x: float,
    cell_y: float,
    touched: Flags,
) -> None:
    """Write which cells a body or an occupied cell of the map touches.

    A body touches the cells on whose edges it ends; a cell of the map has to overlap.

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
        origin_x: Lower left corner of the grid [m].
        origin_y: Lower left corner of the grid [m].
        cell_x: Width of a cell [m].
        cell_y: Height of a cell [m].
        touched: Written, shape ``(columns, rows)``.
    """
    touched[:] = False
    for b in range(blocks.shape[0]):
        if not blocks[b]:
            continue
        for d in range(disc_start[b], disc_start[b] + disc_count[b]):
            x, y, radius = (discs[d, 0] - origin_x) / cell_x, (discs[d, 1] - origin_y) / cell_y, discs[d, 2]
            touch_disc(x, y, radius / cell_x, radius / cell_y, touched)
        for s in range(segment_start[b], segment_start[b] + segment_count[b]):
            ax, ay = (segments[s, 0] - origin_x) / cell_x, (segments[s, 1] - origin_y) / cell_y
            bx, by = (segments[s, 2] - origin_x) / cell_x, (segments[s, 3] - origin_y) / cell_y
            touch_segment(ax, ay, bx, by, touched)
        if solid[b] and segment_count[b] > 0:
            touch_inside(segments, segment_start[b], segment_count[b], origin_x, origin_y, cell_x, cell_y, touched)
    if cells is not None:
        boxes = cells.boxes
        for k in range(boxes.shape[0]):
            left = (cells.x + boxes[k, 0] * cells.width - origin_x) / cell_x
            right = (cells.x + boxes[k, 1] * cells.width - origin_x) / cell_x
            low = (cells.y + boxes[k, 2] * cells.height - origin_y) / cell_y
            high = (cells.y + boxes[k, 3] * cells.height - origin_y) / cell_y
            touch_box(left, right, low, high, touched)


@kernel
def first_touched(low: float, count: int) -> int:
    """Return the first of ``count`` cells that something touches which begins at ``low`` (in cells)."""
    return int(max(min(np.floor(low - EDGE), float(count)), 0.0))


@kernel
def last_touched(high: float, count: int) -> int:
    """Return the last of ``count`` cells that something touches which ends at ``high`` (in cells), -1 for none."""
    return int(max(min(np.floor(high + EDGE), count - 1.0), -1.0))


@kernel
def touch_disc(x: float, y: float, radius_x: float, radius_y: float, touched: Flags) -> None:
    """Mark the cells that a disc touches; its radius in widths and in heights of a cell."""
    columns, rows = touched.shape
    for i in range(first_touched(x - radius_x, columns), last_touched(x + radius_x, columns) + 1):
        dx = max(i - x, x - i - 1.0, 0.0) / radius_x
        for j in range(first_touched(y - radius_y, rows), last_touched(y + radius_y, rows) + 1):
            dy = max(j - y, y - j - 1.0, 0.0) / radius_y
            if dx * dx + dy * dy <= 1.0 + EDGE:
                touched[i, j] = True


@kernel
def touch_segment(ax: float, ay: float, bx: float, by: float, touched: Flags) -> None:
    """Mark the cells that a segment ab touches: neither an edge of the cell nor the segment's line parts them."""
    columns, rows = touched.shape
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
def touch_inside(
    segments: Floats,
    start: int,
    count: int,
    origin_x: float,
    origin_y: float,
    cell_x: float,
    cell_y: float,
    touched: Flags,
) -> None:
    """Mark the cells within the area that segments bound, once those on its boundary are marked."""
    low_x, low_y, high_x, high_y = np.inf, np.inf, -np.inf, -np.inf
    for s in range(start, start + count):
        low_x, high_x = min(low_x, segments[s, 0]), max(high_x, segments[s, 0])
        low_y, high_y = min(low_y, segments[s, 1]), max(high_y, segments[s, 1])
    columns, rows = touched.shape
    first, last = (
        first_touched((low_x - origin_x) / cell_x, columns),
        last_touched((high_x - origin_x) / cell_x, columns),
    )
    low, high = first_touched((low_y - origin_y) / cell_y, rows), last_touched((high_y - origin_y) / cell_y, rows)
    for i in range(first, last + 1):
        for j in range(low, high + 1):
            if touched[i, j]:
                continue
            x, y = origin_x + (i + 0.5) * cell_x, origin_y + (j + 0.5) * cell_y
            touched[i, j] = contains_point(segments, start, count, x, y)


@kernel
def touch_box(left: float, right: float, low: float, high: float, touched: Flags) -> None:
    """Mark the cells that an upright box overlaps."""
    columns, rows = touched.shape
    for i in range(first_touched(left + 2.0 * EDGE, columns), last_touched(right - 2.0 * EDGE, columns) + 1):
        for j in range(first_touched(low + 2.0 * EDGE, rows), last_touched(high - 2.0 * EDGE, rows) + 1):
            touched[i, j] = True
