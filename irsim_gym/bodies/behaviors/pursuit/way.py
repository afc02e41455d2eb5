"""The place of a body on its path, and points ahead on the path."""

import numpy as np

from irsim_gym.base.arraytypes import Floats, Point
from irsim_gym.base.kernels import kernel

WINDOW = 2.0
"""The way is searched so far ahead for where the body is [m], from where it was: it may come near itself later."""


@kernel
def place_on_way(way: Floats, count: int, begin: int, body: Point) -> tuple[int, Point]:
    """Return the side of the way, and the point on it [m], that is nearest to a body; the first of several.

    Args:
        way: The points [m], shape ``(n_points, 2)``.
        count: Number of points, at least 2; side i leads from point i to the next.
        begin: The side where the search begins.
        body: Where the body is [m].
    """
    x, y = body
    best, side, best_x, best_y, gone, i = np.inf, begin, way[begin, 0], way[begin, 1], 0.0, begin
    while i < count - 1 and gone <= WINDOW:
        ax, ay, dx, dy = way[i, 0], way[i, 1], way[i + 1, 0] - way[i, 0], way[i + 1, 1] - way[i, 1]
        length2 = dx * dx + dy * dy
        share = ((x - ax) * dx + (y - ay) * dy) / length2 if length2 > 0.0 else 0.0
        share = min(max(share, 0.0), 1.0)
        px, py = ax + share * dx, ay + share * dy
        distance2 = (px - x) * (px - x) + (py - y) * (py - y)
        if distance2 < best:
            best, side, best_x, best_y = distance2, i, px, py
        # Of the first side, only what lies ahead of the body's foot counts.
        gone += np.sqrt(length2) * (1.0 - share if i == begin else 1.0)
        i += 1
    return side, (best_x, best_y)


@kernel
def remaining_length(way: Floats, count: int, side: int, point: Point) -> float:
    """Return the length of the way [m] from a point on one of its sides to its end."""
    x, y = point
    total = 0.0
    for i in range(side + 1, count):
        total += np.sqrt((way[i, 0] - x) * (way[i, 0] - x) + (way[i, 1] - y) * (way[i, 1] - y))
        x, y = way[i, 0], way[i, 1]
    return total


@kernel
def point_at_distance(way: Floats, count: int, side: int, body: Point, distance: float) -> Point:
    """Return the first point of the way [m], from one of its sides on, that is so far away from a body; else its end.

    Where a side leaves the circle about the body, the point is where they meet; one that passes by the circle has the
    point nearest to it.

    Args:
        way: The points [m], shape ``(n_points, 2)``.
        count: Number of points.
        side: The side where the body is.
        body: Where the body is [m].
        distance: How far away [m].
    """
    x, y = body
    for i in range(side, count - 1):
        bx, by = way[i + 1, 0] - x, way[i + 1, 1] - y
        if bx * bx + by * by < distance * distance:
            continue
        ax, ay = way[i, 0] - x, way[i, 1] - y
        dx, dy = bx - ax, by - ay
        # |a + share d|^2 = distance^2. The greater root is where the side leaves the circle; without roots, the side
        # passes by, and -b / a is its point nearest to the body.
        a, b, c = dx * dx + dy * dy, ax * dx + ay * dy, ax * ax + ay * ay - distance * distance
        root = b * b - a * c
        share = (np.sqrt(max(root, 0.0)) - b) / a if a > 0.0 else 0.0
        share = min(max(share, 0.0), 1.0)
        return x + ax + share * dx, y + ay + share * dy
    return way[count - 1, 0], way[count - 1, 1]
