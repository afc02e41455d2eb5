"""Point maps: obstacles that a body has seen, with at most one point per cell."""

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Point, Rays
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.geometry.segments import point_segment_distance2

MOST_POINT_CELLS = 4_000_000
"""Maximum number of cells of a map of points."""
BLOCK = 8
"""Number of cells of a column that are skipped at once where none of them has a point."""


class PointMap(NamedTuple):
    """At most one point in each square cell over a rectangle.

    Attributes:
        x: Left end of the first cell [m].
        y: Lower end of the first cell [m].
        side: Side of a cell [m].
        places: The points [m], NaN in cells without one, shape ``(columns, rows, 2)``.
        filled: Number k of a column says whether one of its cells from k * BLOCK on, up to the next number's, has a
            point; shape ``(columns, ceil(rows / BLOCK))``.
    """

    x: float
    y: float
    side: float
    places: Rays
    filled: Bytes

    @classmethod
    def over(cls, bounds: Sequence[float] | Floats, side: float, shape: tuple[int, ...]) -> Self:
        """Return empty maps over x_min, y_min, x_max, y_max [m]; ``shape`` gives further leading axes of the arrays.

        Cells are larger than requested if there would be more than ``MOST_POINT_CELLS`` of them.
        """
        x_min, y_min, x_max, y_max = (float(value) for value in bounds)
        side = max(side, float(np.sqrt((x_max - x_min) * (y_max - y_min) / MOST_POINT_CELLS)))
        columns, rows = int(np.ceil((x_max - x_min) / side)) + 1, int(np.ceil((y_max - y_min) / side)) + 1
        # Half a cell more on each side: a point on the edge of the world may be measured on either side of it.
        places = np.full((*shape, columns, rows, 2), np.nan, np.float32)
        filled = np.zeros((*shape, columns, -(-rows // BLOCK)), np.uint8)
        return cls(x_min - 0.5 * side, y_min - 0.5 * side, float(side), places, filled)


@kernel
def points_of(maps: PointMap, w: int, m: int) -> PointMap:
    """Return the map of one member, whose frame all share; the arrays of ``maps`` begin with world and member."""
    return PointMap(maps.x, maps.y, maps.side, maps.places[w, m], maps.filled[w, m])


@kernel
def forget_points(maps: PointMap, w: int, m: int) -> None:
    """Remove all points of one member, see ``points_of``.

    Writes: maps (filled, places).
    """
    maps.places[w, m] = np.nan
    maps.filled[w, m] = 0


@kernel
def add_point(points: PointMap, point: Point, eye: Point) -> None:
    """Add a point [m] seen from another one, unless its cell has a point nearer to that one, or it is off the map."""
    x, y = point
    i, j = np.floor((x - points.x) / points.side), np.floor((y - points.y) / points.side)
    if not (0.0 <= i < points.places.shape[0] and 0.0 <= j < points.places.shape[1]):
        return
    place = points.places[int(i), int(j)]
    dx, dy, old_x, old_y = x - eye[0], y - eye[1], place[0] - eye[0], place[1] - eye[1]
    # An empty cell's NaN fails the comparison.
    if not (old_x * old_x + old_y * old_y <= dx * dx + dy * dy):
        place[0], place[1] = x, y
        points.filled[int(i), int(j) // BLOCK] = 1


@kernel
def cells_between(low: float, high: float, origin: float, side: float, count: int) -> tuple[int, int]:
    """Return the first of ``count`` cells that an interval [m] touches, and the one after the last."""
    first = min(max(np.floor((low - origin) / side), 0.0), float(count))
    end = min(max(np.floor((high - origin) / side) + 1.0, 0.0), float(count))
    return int(first), int(end)


@kernel
def nearest_point2(
    points: PointMap, ax: float, ay: float, bx: float, by: float, reach: float, enough: float
) -> tuple[float, Point]:
    """Return the squared distance [m2] of the segment ab from the nearest point, and that point [m].

    Return inf and (NaN, NaN) if no point is within ``reach`` [m].

    Args:
        points: The points.
        ax: First end [m], as ``ay``, ``bx``, ``by``.
        ay: See ``ax``.
        bx: See ``ax``.
        by: See ``ax``.
        reach: Points farther away are left out [m].
        enough: A distance [m2] at or below which any is as good as the least.
    """
    best, nearest, side, places, dx = np.inf, (np.nan, np.nan), points.side, points.places, bx - ax
    first, end = cells_between(min(ax, bx) - reach, max(ax, bx) + reach, points.x, side, places.shape[0])
    for i in range(first, end):
        # Which part of the segment, in y, a point of this column can be near to.
        low, high = min(ay, by), max(ay, by)
        if dx != 0.0:
            # Points of column i are within reach of the part of the segment between these x only.
            left, right = points.x + i * side - reach, points.x + (i + 1) * side + reach
            start, two = min(max((left - ax) / dx, 0.0), 1.0), min(max((right - ax) / dx, 0.0), 1.0)
            low, high = ay + start * (by - ay), ay + two * (by - ay)
            low, high = min(low, high), max(low, high)
        below, above = cells_between(low - reach, high + reach, points.y, side, places.shape[1])
        for k in range(below // BLOCK, (above + BLOCK - 1) // BLOCK):
            if points.filled[i, k] == 0:
                continue
            for j in range(max(below, k * BLOCK), min(above, (k + 1) * BLOCK)):
                x, y = float(places[i, j, 0]), float(places[i, j, 1])
                # NaN: no point.
                if x != x:
                    continue
                distance2 = point_segment_distance2(x, y, ax, ay, bx, by)
                if distance2 <= reach * reach and distance2 < best:
                    best, nearest = distance2, (x, y)
                    if best <= enough:
                        return best, nearest
    return best, nearest


@kernel
def capsule_meets_points(points: PointMap | None, ax: float, ay: float, bx: float, by: float, radius: float) -> bool:
    """Return whether a point is within ``radius`` [m] of the segment ab, which may be a point; False without a map."""
    # NaN, which does not equal itself, is no point.
    x, _ = blocking_point(points, ax, ay, bx, by, radius)
    return bool(x == x)


@kernel
def blocking_point(points: PointMap | None, ax: float, ay: float, bx: float, by: float, radius: float) -> Point:
    """Return a point within ``radius`` [m] of the segment ab; (NaN, NaN) without any, or without a map."""
    if points is None:
        return np.nan, np.nan
    _, point = nearest_point2(points, ax, ay, bx, by, radius, radius * radius)
    return point


@kernel
def points_distance(points: PointMap | None, place: Point, limit: float) -> float:
    """Return the distance [m] of a place from the nearest of the points, ``limit`` if it is not smaller."""
    if points is None:
        return limit
    distance2, _ = nearest_point2(points, place[0], place[1], place[0], place[1], limit, 0.0)
    return float(min(np.sqrt(distance2), limit))
