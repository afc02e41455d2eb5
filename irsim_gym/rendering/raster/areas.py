"""Discs, rings, polygons and thick lines with smooth edges.

The ``add_`` kernels add areas to a sheet: several areas become one, which is not darker where they overlap. The
``paint_`` kernels paint one area at once. See ``sheets`` for sheets, boxes and colours. Areas with a coordinate that is
NaN or exceeds ``FARTHEST`` pixels are not drawn.
"""

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Point, Rays
from irsim_gym.base.kernels import kernel
from irsim_gym.rendering.raster.records import RasterCanvas
from irsim_gym.rendering.raster.sheets import note, paint, scan_edge

FARTHEST = 1e6
FINENESS, DISC_FINENESS = 16.0, 13.0
"""Corners of the polygon that replaces a circle with a radius of one pixel; the error is less than 0.02 pixels.

A disc needs fewer, because its polygon has the area of the circle and its sides lie on both sides of the circle.
"""
MOST_CORNERS = 2000
SMOOTH = 0.08
"""A corner is drawn straight if that removes less than an eighth of this [pixel]."""


@kernel
def is_near(points: Floats, first: int, count: int) -> bool:
    """Return whether the coordinates of all points are numbers below ``FARTHEST`` in size [pixel]."""
    near = True
    for i in range(first, first + count):
        near = near and abs(points[i, 0]) < FARTHEST and abs(points[i, 1]) < FARTHEST
    return near


@kernel
def note_points(sheet: Rays, box: Ints, points: Floats, first: int, count: int, margin: float) -> bool:
    """Note the region of edges to be added near the points; return False and note nothing unless ``is_near``."""
    if count < 1 or not is_near(points, first, count):
        return False
    left, top, right, foot = points[first, 0], points[first, 1], points[first, 0], points[first, 1]
    for i in range(first + 1, first + count):
        left, right = min(left, points[i, 0]), max(right, points[i, 0])
        top, foot = min(top, points[i, 1]), max(foot, points[i, 1])
    note(sheet, box, left - margin, top - margin, right + margin, foot + margin)
    return True


@kernel
def add_disc(sheet: Rays, box: Ints, x: float, y: float, radius: float, sign: float) -> None:
    """Add a disc to a sheet, or with a negative sign subtract it from a disc around it.

    Args:
        sheet: Sheet to add the disc to.
        box: Part of the picture that is drawn.
        x: Column of the centre [pixel].
        y: Row of the centre [pixel].
        radius: Radius [pixel].
        sign: 1 or -1.
    """
    if not (abs(x) < FARTHEST and abs(y) < FARTHEST and 0.0 < radius < FARTHEST):
        return
    if x + radius < box[0] or x - radius > box[2] or y + radius < box[1] or y - radius > box[3]:
        return
    note(sheet, box, x - radius - 1.0, y - radius - 1.0, x + radius + 1.0, y + radius + 1.0)
    count = int(min(max(DISC_FINENESS * np.sqrt(radius), 12.0), MOST_CORNERS))
    turn = 2.0 * np.pi / count
    cosine, sine = np.cos(turn), np.sin(turn) * sign
    across, down = radius * np.sqrt(turn / abs(sine)), 0.0  # as large an area as the circle's
    for _ in range(count):
        ax, ay = x + across, y + down
        across, down = across * cosine - down * sine, across * sine + down * cosine
        scan_edge(sheet, box, ax, ay, x + across, y + down)


@kernel
def add_polygon(sheet: Rays, box: Ints, points: Floats, first: int, count: int) -> None:
    """Add a polygon to a sheet; the last corner need not repeat the first one.

    Args:
        sheet: Sheet to add the polygon to.
        box: Part of the picture that is drawn.
        points: Corners [pixel], shape ``(n_points, 2)``.
        first: Row of the first corner.
        count: Number of corners.
    """
    if count < 3 or not note_points(sheet, box, points, first, count, 0.0):
        return
    last = first + count - 1
    ax, ay = points[last, 0], points[last, 1]
    for i in range(first, first + count):
        bx, by = points[i, 0], points[i, 1]
        scan_edge(sheet, box, ax, ay, bx, by)
        ax, ay = bx, by


@kernel
def add_line(
    sheet: Rays, box: Ints, points: Floats, first: int, count: int, width: float, closed: bool, round_ends: bool
) -> None:
    """Add a thick line through points to a sheet, with round corners.

    Args:
        sheet: Sheet to add the line to.
        box: Part of the picture that is drawn.
        points: Points on the line [pixel], shape ``(n_points, 2)``.
        first: Row of the first point.
        count: Number of points; a single point is a dot if the ends are round, else nothing.
        width: Width of the line [pixel].
        closed: Whether the line returns to its first point.
        round_ends: Whether the ends are round rather than cut off.
    """
    if not (width > 0.0 and note_points(sheet, box, points, first, count, 0.5 * width + 1.0)):
        return
    half, end = 0.5 * width, first + count
    at, ahead = first, _next_other(points, first, end)
    if ahead < 0:
        if round_ends:
            add_disc(sheet, box, points[first, 0], points[first, 1], half, 1.0)
        return
    begin_x, begin_y, begin_size, x, y, size = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    # For each part of the line: both sides, and the join with the part before. The first part has none before it: a
    # closed line joins it to the last part at the end.
    while ahead >= 0:
        last_x, last_y, last_size = x, y, size
        x, y = points[ahead, 0] - points[at, 0], points[ahead, 1] - points[at, 1]
        size = np.sqrt(x * x + y * y)
        x, y = x / size, y / size
        _add_sides(sheet, box, points[at, 0], points[at, 1], points[ahead, 0], points[ahead, 1], half * x, half * y)
        if last_size > 0.0:
            _add_join(sheet, box, (points[at, 0], points[at, 1]), (last_x, last_y), (x, y), half, min(last_size, size))
        else:
            begin_x, begin_y, begin_size = x, y, size
        if ahead == first:
            break
        at, ahead = ahead, _next_other(points, ahead, end)
        if ahead < 0 and closed and (points[at, 0] != points[first, 0] or points[at, 1] != points[first, 1]):
            ahead = first
    if closed:
        corner = points[first, 0], points[first, 1]
        _add_join(sheet, box, corner, (x, y), (begin_x, begin_y), half, min(begin_size, size))
        return
    _add_end(sheet, box, points[first, 0], points[first, 1], -half * begin_x, -half * begin_y, round_ends)
    _add_end(sheet, box, points[at, 0], points[at, 1], half * x, half * y, round_ends)


@kernel
def _next_other(points: Floats, at: int, end: int) -> int:
    """Return the next point before ``end`` that differs from point ``at``, or -1 if there is none."""
    for i in range(at + 1, end):
        if points[i, 0] != points[at, 0] or points[i, 1] != points[at, 1]:
            return i
    return -1


@kernel
def _add_sides(sheet: Rays, box: Ints, ax: float, ay: float, bx: float, by: float, x: float, y: float) -> None:
    """Add both sides of a line from a to b; x, y is half the width along the line's direction."""
    scan_edge(sheet, box, ax + y, ay - x, bx + y, by - x)
    scan_edge(sheet, box, bx - y, by + x, ax - y, ay + x)


@kernel
def _add_end(sheet: Rays, box: Ints, px: float, py: float, x: float, y: float, is_round: bool) -> None:
    """Add the end of a line at p; x, y is half the width in the direction that leads out of the line."""
    if is_round:
        _add_arc(sheet, box, px, py, y, -x, np.pi)
    else:
        scan_edge(sheet, box, px + y, py - x, px - y, py + x)


@kernel
def _add_join(sheet: Rays, box: Ints, p: Point, a: Point, b: Point, half: float, size: float) -> None:
    """Add the edges that join the sides of a line at a corner p between the directions a and b.

    The outer join is an arc. The inner join is a straight edge; it winds the other way around the area that both parts
    of the line cover, so that this area counts once. If a part is too short for that (``size``), the inner sides meet
    in the corner.
    """
    px, py = p
    ax, ay = a
    bx, by = b
    cross, along = ax * by - ay * bx, ax * bx + ay * by
    if along > 0.0 and half * cross * cross < SMOOTH:
        scan_edge(sheet, box, px + half * ay, py - half * ax, px + half * by, py - half * bx)
        scan_edge(sheet, box, px - half * by, py + half * bx, px - half * ay, py + half * ax)
        return
    # The inner sides cross half * tan(turn / 2) from the corner, which is half * abs(cross) / (1 + along). If a part is
    # shorter than that, they do not reach each other.
    turn, meets = abs(np.arctan2(cross, along)), size * (1.0 + along) < half * abs(cross)
    if cross > 0.0:
        _add_arc(sheet, box, px, py, half * ay, -half * ax, turn)
        ux, uy, vx, vy = -half * by, half * bx, -half * ay, half * ax
    else:
        _add_arc(sheet, box, px, py, -half * by, half * bx, turn)
        ux, uy, vx, vy = half * ay, -half * ax, half * by, -half * bx
    if meets:
        scan_edge(sheet, box, px + ux, py + uy, px, py)
        scan_edge(sheet, box, px, py, px + vx, py + vy)
    else:
        scan_edge(sheet, box, px + ux, py + uy, px + vx, py + vy)


@kernel
def _add_arc(sheet: Rays, box: Ints, px: float, py: float, x: float, y: float, angle: float) -> None:
    """Add the edges of an arc around p that begins at the offset x, y [pixel]."""
    # The error of a polygon is about radius / corners^2, so the corners grow with the root of the radius.
    count = int(FINENESS * np.sqrt(np.sqrt(x * x + y * y)) * angle / (2.0 * np.pi)) + 1
    cosine, sine = np.cos(angle / count), np.sin(angle / count)
    for _ in range(count):
        next_x, next_y = x * cosine - y * sine, x * sine + y * cosine
        scan_edge(sheet, box, px + x, py + y, px + next_x, py + next_y)
        x, y = next_x, next_y


@kernel
def paint_disc(canvas: RasterCanvas, centre: Point, radius: float, colour: Floats) -> None:
    """Paint a disc with its centre at a point [pixel]."""
    picture, sheet, box = canvas
    add_disc(sheet, box, centre[0], centre[1], radius, 1.0)
    paint(picture, sheet, box, colour, False)


@kernel
def paint_ring(canvas: RasterCanvas, x: float, y: float, radius: float, width: float, colour: Floats) -> None:
    """Paint a circle as a line with half of its width on each side [pixel]."""
    picture, sheet, box = canvas
    add_disc(sheet, box, x, y, radius + 0.5 * width, 1.0)
    add_disc(sheet, box, x, y, radius - 0.5 * width, -1.0)
    paint(picture, sheet, box, colour, False)


@kernel
def paint_polygon(canvas: RasterCanvas, points: Floats, first: int, count: int, even_odd: bool, colour: Floats) -> None:
    """Paint a polygon; see ``add_polygon`` for the corners and ``paint`` for the even-odd rule."""
    picture, sheet, box = canvas
    add_polygon(sheet, box, points, first, count)
    paint(picture, sheet, box, colour, even_odd)


@kernel
def paint_line(
    canvas: RasterCanvas,
    points: Floats,
    first: int,
    count: int,
    width: float,
    closed: bool,
    round_ends: bool,
    colour: Floats,
) -> None:
    """Paint a thick line through points; see ``add_line``."""
    picture, sheet, box = canvas
    add_line(sheet, box, points, first, count, width, closed, round_ends)
    paint(picture, sheet, box, colour, False)
