"""Size and middle of a footprint: the least circle around it, and the centre of its area."""

import numpy as np

from irsim_gym.base.arraytypes import Floats, Point
from irsim_gym.base.kernels import kernel

CORNERS = 64
"""Number of points that represent a disc beside other parts."""

SLACK = 1.0 + 1e-12


@kernel
def least_circle(points: Floats, count: int) -> tuple[float, float, float]:
    """Return centre and radius [m] of the least circle around points ``(count, 2)`` (Welzl 1991, without recursion)."""
    if count == 0:
        return 0.0, 0.0, 0.0
    x, y, radius2 = points[0, 0], points[0, 1], 0.0
    for i in range(1, count):
        if is_inside(points[i], x, y, radius2):
            continue
        # Points outside the circle so far lie on the new one: first i alone, then i and j, then i, j and k.
        x, y, radius2 = points[i, 0], points[i, 1], 0.0
        for j in range(i):
            if is_inside(points[j], x, y, radius2):
                continue
            x, y = 0.5 * (points[i, 0] + points[j, 0]), 0.5 * (points[i, 1] + points[j, 1])
            radius2 = (points[i, 0] - x) * (points[i, 0] - x) + (points[i, 1] - y) * (points[i, 1] - y)
            for k in range(j):
                if not is_inside(points[k], x, y, radius2):
                    x, y, radius2 = through(points[i], points[j], points[k], x, y, radius2)
    return x, y, np.sqrt(radius2)


@kernel
def is_inside(point: Floats, x: float, y: float, radius2: float) -> bool:
    """Return whether a point lies in a circle given by centre and squared radius."""
    dx, dy = point[0] - x, point[1] - y
    return bool(dx * dx + dy * dy <= radius2 * SLACK)


@kernel
def through(a: Floats, b: Floats, c: Floats, x: float, y: float, radius2: float) -> tuple[float, float, float]:
    """Return the circle through three points; the given one when they lie on a line."""
    bx, by, cx, cy = b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]
    # Circumcentre relative to a.
    twice = 2.0 * (bx * cy - by * cx)
    if twice == 0.0:
        return x, y, radius2
    b2, c2 = bx * bx + by * by, cx * cx + cy * cy
    ux, uy = (cy * b2 - by * c2) / twice, (bx * c2 - cx * b2) / twice
    return a[0] + ux, a[1] + uy, ux * ux + uy * uy


@kernel
def centre_of_mass(segments: Floats, discs: Floats, solid: bool) -> Point:
    """Return the centre of an outline's area [m], or of its length when it bounds none.

    Parts that overlap count twice.

    Args:
        segments: x0, y0, x1, y1 [m], shape ``(n, 4)``; counter-clockwise when they bound an area.
        discs: x, y, radius [m], shape ``(n, 3)``.
        solid: The segments bound an area.
    """
    weight, x, y = 0.0, 0.0, 0.0
    for s in range(segments.shape[0]):
        ax, ay, bx, by = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
        if solid:
            # Signed area of the triangle of the origin and the edge; its centre is a third of the sum of its corners.
            cross = 0.5 * (ax * by - ay * bx)
            weight += cross
            x += cross * (ax + bx) / 3.0
            y += cross * (ay + by) / 3.0
        else:
            length = np.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
            weight += length
            x += length * 0.5 * (ax + bx)
            y += length * 0.5 * (ay + by)
    for d in range(discs.shape[0]):
        area = np.pi * discs[d, 2] * discs[d, 2]
        weight += area
        x += area * discs[d, 0]
        y += area * discs[d, 1]
    return (x / weight, y / weight) if weight > 0.0 else (0.0, 0.0)


@kernel
def corner_points(segments: Floats, discs: Floats, points: Floats) -> int:
    """Write the ends of segments, and points on discs, that a circle must hold; return their number.

    Args:
        segments: x0, y0, x1, y1 [m], shape ``(n_segments, 4)``.
        discs: x, y, radius [m], shape ``(n_discs, 3)``.
        points: Written, shape ``(2 * n_segments + CORNERS * n_discs, 2)`` or more.
    """
    count = 0
    for s in range(segments.shape[0]):
        points[count, 0], points[count, 1] = segments[s, 0], segments[s, 1]
        points[count + 1, 0], points[count + 1, 1] = segments[s, 2], segments[s, 3]
        count += 2
    for d in range(discs.shape[0]):
        for k in range(CORNERS):
            angle = 2.0 * np.pi * k / CORNERS
            points[count, 0] = discs[d, 0] + discs[d, 2] * np.cos(angle)
            points[count, 1] = discs[d, 1] + discs[d, 2] * np.sin(angle)
            count += 1
    return count
