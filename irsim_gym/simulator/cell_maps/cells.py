"""An occupancy map: which of many equal rectangles are occupied, and what touches or sees them.

Cells, and the discs that may stand in them, are closed sets, so touching one is overlapping it. These kernels take the
map of one world; ``world_maps`` holds those of many, or None.
"""

import numpy as np

from irsim_gym.base.arraytypes import BodyOutline, Bytes, CellMap, Flags, Point, Spans
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.cell_maps.cell_room import nearest_to_point2, room_about, segment_disc_distance2
from irsim_gym.simulator.geometry.polygons import holds_point
from irsim_gym.simulator.geometry.segments import point_segment_distance2, side

Cell = tuple[int, int]
"""Column and row."""
LARGEST = 255
SLACK = 1e-9
"""Margin of searches for cells [cells], so that rounding loses none. An exact test follows."""


@kernel
def find_free_squares(occupied: Flags, squares: Bytes) -> None:
    """Write the sides of the largest free squares, by the recurrence 1 + min of three neighbours.

    Args:
        occupied: Occupied cells, shape ``(columns, rows)``.
        squares: Written: sides [cells], shape ``(4, columns, rows)``.
    """
    columns, rows = occupied.shape
    for quadrant in range(4):
        # The square grows by (step_x, step_y), so the loops run the other way: the neighbours are done first. Beyond
        # the map all is free.
        step_x, step_y = 1 - 2 * (quadrant % 2), 1 - 2 * (quadrant // 2)
        for a in range(columns):
            i = columns - 1 - a if step_x > 0 else a
            for b in range(rows):
                j = rows - 1 - b if step_y > 0 else b
                if occupied[i, j]:
                    squares[quadrant, i, j] = 0
                    continue
                # Dynamic programming: a square needs those of the three cells next to its corner.
                beside = int(squares[quadrant, i + step_x, j]) if a > 0 else LARGEST
                above = int(squares[quadrant, i, j + step_y]) if b > 0 else LARGEST
                across = int(squares[quadrant, i + step_x, j + step_y]) if a > 0 and b > 0 else LARGEST
                squares[quadrant, i, j] = min(1 + min(beside, above, across), LARGEST)


@kernel
def find_boxes(occupied: Flags, boxes: Spans) -> int:
    """Write boxes that cover exactly the occupied cells. Equal runs of neighbouring columns form a box.

    Args:
        occupied: Occupied cells, shape ``(columns, rows)``.
        boxes: Written: first column, end column, first row, end row, in ascending order, shape ``(n, 4)``; those for
            which it has no row are left out.

    Returns:
        How many boxes there are.
    """
    columns, rows = occupied.shape
    count = 0
    for i in range(columns):
        begin, j = count, 0
        while j < rows:
            if not occupied[i, j]:
                j += 1
                continue
            first = j
            while j < rows and occupied[i, j]:
                j += 1
            # The box of the column before covers this run already.
            if i > 0 and is_run(occupied, i - 1, first, j):
                continue
            end = i + 1
            while end < columns and is_run(occupied, end, first, j):
                end += 1
            if count < boxes.shape[0]:
                # Boxes that begin in one column are kept in the order of their ends (insertion sort).
                place = count
                while place > begin and boxes[place - 1, 1] > end:
                    for k in range(4):
                        boxes[place, k] = boxes[place - 1, k]
                    place -= 1
                boxes[place, 0], boxes[place, 1], boxes[place, 2], boxes[place, 3] = i, end, first, j
            count += 1
    return count


@kernel
def is_run(occupied: Flags, i: int, first: int, end: int) -> bool:
    """Return whether the cells of column i from row ``first`` to before ``end`` are occupied, and the next are not."""
    if (first > 0 and occupied[i, first - 1]) or (end < occupied.shape[1] and occupied[i, end]):
        return False
    j = first
    while j < end and occupied[i, j]:
        j += 1
    return j == end


@kernel
def box_is_free(squares: Bytes, first: Cell, last: Cell) -> bool:
    """Return True if the free squares along one side of a box of cells cover all of it; False proves nothing."""
    first_i, first_j, last_i, last_j = first[0], first[1], last[0], last[1]
    width, height = last_i - first_i + 1, last_j - first_j + 1
    if width <= height:
        # A box that is higher than wide is covered by squares at least as wide as it is, stacked in its first column.
        j = first_j
        while j <= last_j:
            free = int(squares[0, first_i, j])
            if free < width:
                return False
            j += free
        return True
    i = first_i
    while i <= last_i:
        free = int(squares[0, i, first_j])
        if free < height:
            return False
        i += free
    return True


@kernel
def cell_range(low: float, high: float, origin: float, cell: float, count: int) -> tuple[int, int]:
    """Return the first and the last of ``count`` cells that touch an interval [m]; none if last < first."""
    # Cells are closed: an interval that begins on a border touches the cell before it, too.
    first = max(np.ceil((low - origin) / cell - SLACK) - 1.0, 0.0)
    last = min(np.floor((high - origin) / cell + SLACK), count - 1.0)
    if first > last:
        return 0, -1
    return int(first), int(last)


@kernel
def strip_rows(ax: float, ay: float, bx: float, by: float, reach: float, i: int, cells: CellMap) -> tuple[int, int]:
    """Return the first and last row of column i that come within ``reach`` [m] of the segment ab, or some more."""
    low, high = min(ay, by), max(ay, by)
    dx = bx - ax
    if dx != 0.0:
        left, right = cells.x + i * cells.width - reach, cells.x + (i + 1) * cells.width + reach
        # Where the segment enters and leaves the widened column, as a share of its length; a segment beside it is cut
        # to an end.
        enter, leave = (left - ax) / dx, (right - ax) / dx
        enter, leave = min(max(min(enter, leave), 0.0), 1.0), max(min(max(enter, leave), 1.0), 0.0)
        y_enter, y_leave = ay + enter * (by - ay), ay + leave * (by - ay)
        low, high = min(y_enter, y_leave), max(y_enter, y_leave)
    return cell_range(low - reach, high + reach, cells.y, cells.height, cells.squares.shape[2])


@kernel
def segment_box_distance2(
    ax: float, ay: float, bx: float, by: float, left: float, low: float, right: float, high: float
) -> float:
    """Return the squared distance [m2] between the segment ab, which may be a point, and an upright box."""
    if max(ax, bx) >= left and min(ax, bx) <= right and max(ay, by) >= low and min(ay, by) <= high:
        # If the boxes overlap, the segment meets the box unless all four corners lie strictly on one side of its line.
        west, two = side(ax, ay, bx, by, left, low), side(ax, ay, bx, by, right, low)
        three, four = side(ax, ay, bx, by, right, high), side(ax, ay, bx, by, left, high)
        if min(west, two, three, four) <= 0.0 and max(west, two, three, four) >= 0.0:
            return 0.0
    best = min(
        point_segment_distance2(left, low, ax, ay, bx, by),
        point_segment_distance2(right, low, ax, ay, bx, by),
        point_segment_distance2(right, high, ax, ay, bx, by),
        point_segment_distance2(left, high, ax, ay, bx, by),
    )
    # What is left are the distances of both ends from the box.
    gap_x, gap_y = max(left - ax, ax - right, 0.0), max(low - ay, ay - high, 0.0)
    best = min(best, gap_x * gap_x + gap_y * gap_y)
    gap_x, gap_y = max(left - bx, bx - right, 0.0), max(low - by, by - high, 0.0)
    return min(best, gap_x * gap_x + gap_y * gap_y)


@kernel
def nearest_cell2(cells: CellMap, ax: float, ay: float, bx: float, by: float, reach: float, enough: float) -> float:
    """Return the squared distance [m2] of the segment ab from the occupied cells, inf if none is near.

    Args:
        cells: The map.
        ax: First end [m], as ``ay``, ``bx``, ``by``.
        ay: See ``ax``.
        bx: See ``ax``.
        by: See ``ax``.
        reach: Cells farther away than this [m] may be left out.
        enough: A distance [m2] at or below which any is as good as the least.
    """
    best, squares = np.inf, cells.squares
    columns, rows = squares.shape[1], squares.shape[2]
    first_i, last_i = cell_range(min(ax, bx) - reach, max(ax, bx) + reach, cells.x, cells.width, columns)
    first_j, last_j = cell_range(min(ay, by) - reach, max(ay, by) + reach, cells.y, cells.height, rows)
    if last_i < first_i or last_j < first_j or box_is_free(squares, (first_i, first_j), (last_i, last_j)):
        return best
    for i in range(first_i, last_i + 1):
        left, right = cells.x + i * cells.width, cells.x + (i + 1) * cells.width
        # Horizontal, and below (``up``) vertical gap between a cell and the box around the segment: a bound that spares
        # most exact distances.
        aside = max(left - max(ax, bx), min(ax, bx) - right, 0.0)
        j, last = strip_rows(ax, ay, bx, by, reach, i, cells)
        while j <= last:
            # The free square to the upper right of a cell says how many rows above are free, too: skip them.
            if squares[0, i, j] > 0:
                j += int(squares[0, i, j])
                continue
            low, high = cells.y + j * cells.height, cells.y + (j + 1) * cells.height
            up = max(low - max(ay, by), min(ay, by) - high, 0.0)
            if aside * aside + up * up < best:
                if cells.radius > 0.0:
                    best = min(best, segment_disc_distance2(cells, i, j, ax, ay, bx, by))
                else:
                    best = min(best, segment_box_distance2(ax, ay, bx, by, left, low, right, high))
                if best <= enough:
                    return best
            j += 1
    return best


@kernel
def capsule_meets_cells(cells: CellMap, ax: float, ay: float, bx: float, by: float, radius: float) -> bool:
    """Return whether an occupied cell comes within ``radius`` [m] (0 allowed) of the segment ab, which may be a point.

    Args:
        cells: The map.
        ax: First end [m], as ``ay``, ``bx``, ``by``.
        ay: See ``ax``.
        bx: See ``ax``.
        by: See ``ax``.
        radius: Distance [m] that counts as touching.
    """
    # No point of the segment is farther than ``half`` from its middle, for which the map holds bounds.
    half = 0.5 * np.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
    least, most = room_about(cells, 0.5 * (ax + bx), 0.5 * (ay + by))
    if least > radius + half * (1.0 + SLACK):
        return False
    if most < radius:
        return True
    if half == 0.0:
        return bool(nearest_to_point2(cells, ax, ay, radius) <= radius * radius)
    return bool(nearest_cell2(cells, ax, ay, bx, by, radius, radius * radius) <= radius * radius)


@kernel
def segment_cells_distance(cells: CellMap, ax: float, ay: float, bx: float, by: float, limit: float) -> float:
    """Return the distance [m] of the segment ab from the nearest occupied cell, ``limit`` (may be inf) if not smaller.

    The search reaches as far as the room in the segment's middle says, and where that is unknown it doubles its reach
    until it finds a cell.
    """
    squares = cells.squares
    half = 0.5 * np.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
    least, most = room_about(cells, 0.5 * (ax + bx), 0.5 * (ay + by))
    if least - half * (1.0 + SLACK) >= limit:
        return limit
    reach = most if most < np.inf else 4.0 * max(cells.width, cells.height)
    width, height = cells.width * squares.shape[1], cells.height * squares.shape[2]
    centre_x, centre_y = cells.x + 0.5 * width, cells.y + 0.5 * height
    # A reach that covers the whole map, from wherever the segment is.
    whole = abs(centre_x - ax) + abs(centre_y - ay) + width + height
    while True:
        reach = min(reach, limit, whole)
        if half == 0.0:
            best = np.sqrt(nearest_to_point2(cells, ax, ay, reach))
        else:
            best = np.sqrt(nearest_cell2(cells, ax, ay, bx, by, reach, 0.0))
        # All cells within ``reach`` were searched, so a distance up to it is the least.
        if best <= reach or reach >= limit or reach >= whole:
            return float(min(best, limit))
        reach = 2.0 * reach


@kernel
def cells_are_closer(cells: CellMap, point: Point, limit: float) -> bool:
    """Return whether an occupied cell comes closer than ``limit`` [m] to a point."""
    x, y = point
    _, most = room_about(cells, x, y)
    return bool(most < limit or segment_cells_distance(cells, x, y, x, y, limit) < limit)


@kernel
def nearest_cell_point(cells: CellMap, x: float, y: float, limit: float) -> tuple[float, float, float]:
    """Return distance and position [m] of the nearest point of an occupied cell; inf and (x, y) if none is in limit."""
    squares = cells.squares
    best, best_x, best_y = np.inf, x, y
    reach = segment_cells_distance(cells, x, y, x, y, limit) * (1.0 + SLACK)
    if reach >= limit:
        return best, best_x, best_y
    first_i, last_i = cell_range(x - reach, x + reach, cells.x, cells.width, squares.shape[1])
    first_j, last_j = cell_range(y - reach, y + reach, cells.y, cells.height, squares.shape[2])
    for i in range(first_i, last_i + 1):
        for j in range(first_j, last_j + 1):
            if squares[0, i, j] > 0:
                continue
            px = min(max(x, cells.x + i * cells.width), cells.x + (i + 1) * cells.width)
            py = min(max(y, cells.y + j * cells.height), cells.y + (j + 1) * cells.height)
            if cells.radius > 0.0:
                px, py = nearest_disc_point(cells, i, j, (x, y))
            distance = np.sqrt((px - x) * (px - x) + (py - y) * (py - y))
            if distance < best:
                best, best_x, best_y = distance, px, py
    return best, best_x, best_y


@kernel
def nearest_disc_point(cells: CellMap, i: int, j: int, point: Point) -> Point:
    """Return the point of the disc in a cell that is nearest to a point [m]: that point itself if it lies within."""
    x, y = point
    cx, cy = cells.x + (i + 0.5) * cells.width, cells.y + (j + 0.5) * cells.height
    away = np.sqrt((x - cx) * (x - cx) + (y - cy) * (y - cy))
    share = cells.radius / away if away > cells.radius else 1.0
    return cx + share * (x - cx), cy + share * (y - cy)


@kernel
def outline_meets_cells(cells: CellMap, outline: BodyOutline) -> bool:
    """Return whether an outline touches an occupied cell, or holds one."""
    segments, discs = outline.segments, outline.discs
    for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
        if capsule_meets_cells(cells, discs[d, 0], discs[d, 1], discs[d, 0], discs[d, 1], discs[d, 2]):
            return True
    for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
        if capsule_meets_cells(cells, segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3], 0.0):
            return True
    return outline.solid and outline.n_segments > 0 and holds_cell(cells, outline)


@kernel
def holds_cell(cells: CellMap, outline: BodyOutline) -> bool:
    """Return whether an area whose boundary touches no occupied cell holds one.

    Occupied cells that touch each other are then on one side, so one point of each run in a column is enough. Discs in
    neighbouring cells need not touch each other, so each is tested.
    """
    squares, segments = cells.squares, outline.segments
    left, low, right, high = np.inf, np.inf, -np.inf, -np.inf
    for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
        left, right = min(left, segments[s, 0]), max(right, segments[s, 0])
        low, high = min(low, segments[s, 1]), max(high, segments[s, 1])
    first_i, last_i = cell_range(left, right, cells.x, cells.width, squares.shape[1])
    first_j, last_j = cell_range(low, high, cells.y, cells.height, squares.shape[2])
    if last_i < first_i or last_j < first_j or box_is_free(squares, (first_i, first_j), (last_i, last_j)):
        return False
    for i in range(first_i, last_i + 1):
        j = first_j
        while j <= last_j:
            if squares[0, i, j] > 0:
                j += int(squares[0, i, j])
                continue
            if holds_point(outline, (cells.x + (i + 0.5) * cells.width, cells.y + (j + 0.5) * cells.height)):
                return True
            j += 1
            # The rest of the run touches this cell; discs of neighbouring cells may be apart.
            while cells.radius == 0.0 and j <= last_j and squares[0, i, j] == 0:
                j += 1
    return False


@kernel
def outline_cells_distance(cells: CellMap, outline: BodyOutline, limit: float) -> float:
    """Return the distance [m] of an outline from the nearest occupied cell: 0 if they touch, at most ``limit``."""
    if outline.solid and outline.n_segments > 0 and holds_cell(cells, outline):
        return 0.0
    best, segments, discs = limit, outline.segments, outline.discs
    for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
        x, y, radius = discs[d, 0], discs[d, 1], discs[d, 2]
        near = segment_cells_distance(cells, x, y, x, y, best + radius)
        if near < best + radius:
            best = min(best, max(near - radius, 0.0))
    for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
        ax, ay, bx, by = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
        best = segment_cells_distance(cells, ax, ay, bx, by, best)
    return best


@kernel
def outline_near_cells(cells: CellMap, outline: BodyOutline, clearance: float) -> bool:
    """Return whether an outline touches an occupied cell, or comes closer than ``clearance`` [m] to one."""
    for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
        _, most = room_about(cells, outline.discs[d, 0], outline.discs[d, 1])
        if most < outline.discs[d, 2] + clearance:
            return True
    if clearance <= 0.0:
        return bool(outline_meets_cells(cells, outline))
    return bool(outline_cells_distance(cells, outline, clearance) < clearance)
