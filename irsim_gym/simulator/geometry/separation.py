"""How deep convex pieces overlap, and which way is the shortest apart: the test of separating axes."""

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.kernels import kernel

Piece = tuple[int, int, float]
"""First row of its corners, their number, and its radius [m]; a disc has one corner, a segment two."""
Overlap = tuple[float, float, float, float, float]
"""Depth [m]; unit vector along which the first piece leaves the second one; a point of the overlap [m]."""

CLOSE = 1e-5
"""Pieces that are apart by less than this [m] touch; their depth is negative."""
APART: Overlap = (-np.inf, 0.0, 0.0, 0.0, 0.0)
SAME_HEIGHT = 1e-7
"""Corners this close to the outermost one [m] touch with it."""
TINY = 1e-12
"""Shorter edges and vectors have no direction."""


@kernel
def overlap(corners: Floats, a: Piece, b: Piece) -> Overlap:
    """Return the overlap of two convex pieces, ``APART`` if there is none.

    Args:
        corners: Corners of all pieces [m], shape ``(n, 2)``.
        a: The piece that leaves.
        b: The piece that stays.
    """
    if a[2] > 0.0 and b[2] > 0.0:
        return disc_overlap(corners, a, b)
    depth, nx, ny = np.inf, 0.0, 0.0
    for side in range(2):
        one, other = (a, b) if side == 0 else (b, a)
        # A segment has one edge, and a disc one axis: through the nearest corner of the other piece.
        for i in range(one[1] if one[1] > 2 else 1):
            x, y = axis_from_corner(corners, one, other) if one[2] > 0.0 else edge_normal(corners, one, i)
            if x == 0.0 and y == 0.0:
                continue
            low_a, high_a = extent_along(corners, a, x, y)
            low_b, high_b = extent_along(corners, b, x, y)
            down, up = high_a - low_b, high_b - low_a
            least = min(down, up)
            if least < -CLOSE:
                return APART
            if least < depth:
                depth = least
                nx, ny = (x, y) if up <= down else (-x, -y)
    px, py = touching_point(corners, a, b, nx, ny)
    return depth, nx, ny, px, py


@kernel
def disc_overlap(corners: Floats, a: Piece, b: Piece) -> Overlap:
    """Return the overlap of two discs."""
    x, y = corners[b[0], 0], corners[b[0], 1]
    dx, dy = corners[a[0], 0] - x, corners[a[0], 1] - y
    distance = np.sqrt(dx * dx + dy * dy)
    depth = a[2] + b[2] - distance
    if depth < -CLOSE:
        return APART
    nx, ny = (dx / distance, dy / distance) if distance > TINY else (1.0, 0.0)
    half = b[2] - 0.5 * depth
    return depth, nx, ny, x + nx * half, y + ny * half


@kernel
def edge_normal(corners: Floats, piece: Piece, i: int) -> tuple[float, float]:
    """Return the unit normal of edge i of a piece, zeros for one without a length."""
    first, last = piece[0] + i, piece[0] + (i + 1 if i + 1 < piece[1] else 0)
    ex, ey = corners[last, 0] - corners[first, 0], corners[last, 1] - corners[first, 1]
    length = np.sqrt(ex * ex + ey * ey)
    return (ey / length, -ex / length) if length >= TINY else (0.0, 0.0)


@kernel
def axis_from_corner(corners: Floats, disc: Piece, other: Piece) -> tuple[float, float]:
    """Return the unit vector from the nearest corner of a piece to the centre of a disc, zeros if they coincide."""
    x, y, best2, nx, ny = corners[disc[0], 0], corners[disc[0], 1], np.inf, 0.0, 0.0
    for k in range(other[0], other[0] + other[1]):
        dx, dy = x - corners[k, 0], y - corners[k, 1]
        distance2 = dx * dx + dy * dy
        if distance2 < best2:
            best2, nx, ny = distance2, dx, dy
    distance = np.sqrt(best2)
    return (nx / distance, ny / distance) if distance >= TINY else (0.0, 0.0)


@kernel
def extent_along(corners: Floats, piece: Piece, x: float, y: float) -> tuple[float, float]:
    """Return the lowest and highest coordinate of a piece along a unit vector [m]."""
    low, high = np.inf, -np.inf
    for k in range(piece[0], piece[0] + piece[1]):
        at = corners[k, 0] * x + corners[k, 1] * y
        low, high = min(low, at), max(high, at)
    return low - piece[2], high + piece[2]


@kernel
def touching_point(corners: Floats, a: Piece, b: Piece, nx: float, ny: float) -> tuple[float, float]:
    """Return the middle of what touches [m]: the lowest corners of a along a unit vector, and the highest ones of b."""
    low, _ = extent_along(corners, a, nx, ny)
    _, high = extent_along(corners, b, nx, ny)
    a0, a1 = feature(corners, a, nx, ny, low + a[2])
    b0, b1 = feature(corners, b, nx, ny, high - b[2])
    begin, end = max(a0, b0), min(a1, b1)
    along = 0.5 * (begin + end) if begin <= end else 0.25 * (a0 + a1 + b0 + b1)
    across = 0.5 * (low + high)
    return nx * across - ny * along, ny * across + nx * along


@kernel
def feature(corners: Floats, piece: Piece, nx: float, ny: float, height: float) -> tuple[float, float]:
    """Return how far the corners at a height along a unit vector reach to its left [m]."""
    low, high = np.inf, -np.inf
    for k in range(piece[0], piece[0] + piece[1]):
        if abs(corners[k, 0] * nx + corners[k, 1] * ny - height) <= SAME_HEIGHT:
            along = corners[k, 1] * nx - corners[k, 0] * ny
            low, high = min(low, along), max(high, along)
    return low, high
