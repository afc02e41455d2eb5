"""Polygons, as lists of edges or of vertices."""

import numpy as np

from irsim_gym.base.arraytypes import BodyOutline, Floats, Point
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.geometry.segments import side


@kernel
def contains_point(segments: Floats, start: int, count: int, point: Point) -> bool:
    """Return whether a point [m] lies within the area that segments enclose, by the even-odd rule.

    The segments may come in any order and direction. A point on the boundary may get either answer.

    Args:
        segments: x0, y0, x1, y1 [m], shape ``(segment, 4)``.
        start: First row of the boundary.
        count: Number of its rows.
        point: The point [m].
    """
    x, y, inside = point[0], point[1], False
    for s in range(start, start + count):
        ax, ay, bx, by = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
        # The edge crosses the height of the point, and does so to the right of it: each such crossing changes the
        # answer.
        if (ay > y) != (by > y) and (side(ax, ay, bx, by, x, y) > 0.0) == (by > ay):
            inside = not inside
    return inside


@kernel
def holds_point(outline: BodyOutline, point: Point) -> bool:
    """Return whether a point [m] lies within the area that the segments of an outline enclose."""
    return contains_point(outline.segments, outline.first_segment, outline.n_segments, point)


@kernel
def signed_area(vertices: Floats) -> float:
    """Return the area [m2] of a polygon with vertices ``(n, 2)`` [m]: positive if they run counter-clockwise."""
    twice, n = 0.0, vertices.shape[0]
    for i in range(2, n):
        twice += side(
            vertices[0, 0], vertices[0, 1], vertices[i - 1, 0], vertices[i - 1, 1], vertices[i, 0], vertices[i, 1]
        )
    return 0.5 * twice


@kernel
def is_convex(vertices: Floats) -> bool:
    """Return whether a polygon with vertices ``(n, 2)`` [m] is convex.

    Straight angles and repeated vertices are allowed; a boundary that turns back or winds more than once is not
    convex, nor is one without area.
    """
    n = vertices.shape[0]
    # The edge before the first one: the last edge that has a length.
    last_x, last_y = 0.0, 0.0
    for i in range(n):
        before = i - 1 if i > 0 else n - 1
        dx, dy = vertices[i, 0] - vertices[before, 0], vertices[i, 1] - vertices[before, 1]
        if dx != 0.0 or dy != 0.0:
            last_x, last_y = dx, dy
    left, right, turned = False, False, 0.0
    for i in range(n):
        before = i - 1 if i > 0 else n - 1
        dx, dy = vertices[i, 0] - vertices[before, 0], vertices[i, 1] - vertices[before, 1]
        if dx == 0.0 and dy == 0.0:
            continue
        cross, dot = last_x * dy - last_y * dx, last_x * dx + last_y * dy
        if cross == 0.0 and dot < 0.0:
            return False
        left, right = left or cross > 0.0, right or cross < 0.0
        turned += np.arctan2(cross, dot)
        last_x, last_y = dx, dy
    # All turns go one way, and they add up to one full turn (2 pi) rather than two or more.
    return left != right and abs(turned) < 3.0 * np.pi


@kernel
def reach(segments: Floats, start: int, count: int, discs: Floats, disc_start: int, disc_count: int) -> float:
    """Return the largest distance [m] of an outline from the origin of its frame; 0 for an empty one.

    Args:
        segments: x0, y0, x1, y1 [m], shape ``(segment, 4)``.
        start: First row of the outline's segments.
        count: Number of them.
        discs: x, y, radius [m], shape ``(disc, 3)``.
        disc_start: First row of the outline's discs.
        disc_count: Number of them.
    """
    largest2 = 0.0
    for s in range(start, start + count):
        ax, ay, bx, by = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
        largest2 = max(largest2, ax * ax + ay * ay, bx * bx + by * by)
    largest = np.sqrt(largest2)
    for d in range(disc_start, disc_start + disc_count):
        x, y = discs[d, 0], discs[d, 1]
        largest = max(largest, np.sqrt(x * x + y * y) + discs[d, 2])
    return float(largest)
