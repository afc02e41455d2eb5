"""Kernels that paint solid or dashed lines, and outlines of footprints."""

import numpy as np

from irsim_gym.rendering.raster.areas import FINENESS, MOST_CORNERS, add_disc, add_line, add_polygon, is_near
from irsim_gym.rendering.raster.records import RasterCanvas, RasterOutline
from irsim_gym.rendering.raster.sheets import paint
from irsim_gym.simulator.world.names import Floats, Ints, Rays, kernel

SOLID, DASHED, DASHDOT, DOTTED = 0, 1, 2, 3
DASHES = np.array([[1.0, 0.0, 1.0, 0.0], [3.7, 1.6, 3.7, 1.6], [6.4, 1.6, 1.0, 1.6], [1.0, 1.65, 1.0, 1.65]])
"""Lengths of dash, gap, dash, gap of each line style, in widths of the line."""
GAP = 1e-6
"""Segments with a larger gap than this are not connected [m]."""
ALIGNED = 1e-4
"""A line that deviates less than this from a row or column of pixels is parallel to it [pixel]."""


@kernel
def add_way(
    sheet: Rays, box: Ints, points: Floats, count: int, line: tuple[float, int, float], closed: bool, round_ends: bool
) -> None:
    """Add a line through the first ``count`` points to a sheet.

    ``line`` is the line's width [pixel], its style, and the length of the line whose dashes it continues [pixel]. The
    points after the first ``count`` are overwritten; ``points`` must have room for ``2 count + 3``.
    """
    width, style, before = line
    if style == SOLID:
        add_line(sheet, box, points, 0, count, width, closed, round_ends)
        return
    if not is_near(points, 0, count):
        return
    # Parts 0 and 2 are dashes, 1 and 3 gaps; ``left`` is what is left of the part. The points of a dash are collected
    # from ``fresh`` on; ``ahead`` is the next free place.
    part, left, fresh, ahead = 0, DASHES[style, 0] * width, count, count
    # Go on where the dashes of the line before ended.
    rest = before % (DASHES[style].sum() * width)
    while rest >= left > 0.0:
        rest, part = rest - left, (part + 1) % 4
        left = DASHES[style, part] * width
    left -= rest
    for i in range(count if closed else count - 1):
        after = (i + 1) % count
        ax, ay = points[i, 0], points[i, 1]
        dx, dy = points[after, 0] - ax, points[after, 1] - ay
        size, along = np.sqrt(dx * dx + dy * dy), 0.0
        if part % 2 == 0:
            points[ahead, 0], points[ahead, 1] = ax, ay
            ahead += 1
        while along < size and left > 0.0:
            step = min(left, size - along)
            along, left = along + step, left - step
            x, y = ax + dx * along / size, ay + dy * along / size
            if left > 0.0:
                continue
            if part % 2 == 0:
                points[ahead, 0], points[ahead, 1] = x, y
                add_line(sheet, box, points, fresh, ahead + 1 - fresh, width, False, round_ends)
                ahead = fresh
            else:
                points[ahead, 0], points[ahead, 1] = x, y
                ahead += 1
            part = (part + 1) % 4
            left = DASHES[style, part] * width
    # The last dash is cut off by the end of the line.
    if part % 2 == 0 and ahead > fresh:
        last = 0 if closed else count - 1
        points[ahead, 0], points[ahead, 1] = points[last, 0], points[last, 1]
        add_line(sheet, box, points, fresh, ahead + 1 - fresh, width, False, round_ends)


@kernel
def paint_outline(
    canvas: RasterCanvas,
    points: Floats,
    outline: RasterOutline,
    place: Floats,
    inks: tuple[Floats, Floats],
    stroke: tuple[float, int, bool],
) -> None:
    """Paint the area of an outline and a line along its boundary.

    Args:
        canvas: Canvas to paint on.
        points: Scratch memory for points.
        outline: The outline.
        place: Transform from metres to pixels: columns are ``place[0] x + place[1] y + place[2]``, rows use the next
            three entries alike, and ``place[6]`` is the pixels per metre.
        inks: Colours and opacities of the area and of the line.
        stroke: The line's width [pixel], its style, and whether it is snapped to whole pixels if all segments are
            parallel to rows or columns.
    """
    picture, sheet, box = canvas
    segments, segment_rows, discs, disc_rows = outline
    area, edge = inks
    width, style, snapped = stroke
    shift = snapping(segments, segment_rows, disc_rows[1], place, width) if snapped else -1.0
    if area[3] > 0.0:
        row, end = segment_rows[0], segment_rows[0] + segment_rows[1]
        while row < end:
            count, _ = load_chain(points, segments, row, end, place, shift)
            add_polygon(sheet, box, points, 0, count)
            row += count - 1
        for row in range(disc_rows[0], disc_rows[0] + disc_rows[1]):
            x, y = discs[row, 0], discs[row, 1]
            column = place[0] * x + place[1] * y + place[2]
            # -1 winds as polygons do that are counter-clockwise in the world, so that parts which overlap add up.
            add_disc(sheet, box, column, place[3] * x + place[4] * y + place[5], discs[row, 2] * place[6], -1.0)
        paint(picture, sheet, box, area, False)
    if edge[3] > 0.0 and width > 0.0:
        row, end = segment_rows[0], segment_rows[0] + segment_rows[1]
        while row < end:
            count, closed = load_chain(points, segments, row, end, place, shift)
            row += count - 1
            add_way(sheet, box, points, count - 1 if closed else count, (width, style, 0.0), closed, True)
        for row in range(disc_rows[0], disc_rows[0] + disc_rows[1]):
            x, y = discs[row, 0], discs[row, 1]
            column, line = place[0] * x + place[1] * y + place[2], place[3] * x + place[4] * y + place[5]
            _add_circle(sheet, box, points, column, line, discs[row, 2] * place[6], width, style)
        paint(picture, sheet, box, edge, False)


@kernel
def load_chain(points: Floats, segments: Floats, row: int, end: int, place: Floats, shift: float) -> tuple[int, bool]:
    """Write the vertices of connected segments in pixels, beginning with the segment at ``row``.

    Returns:
        Number of vertices, one more than segments, and whether the last vertex equals the first one.
    """
    x, y, count, last = segments[row, 0], segments[row, 1], 0, row
    while True:
        column, line = place[0] * x + place[1] * y + place[2], place[3] * x + place[4] * y + place[5]
        if shift >= 0.0:
            column, line = np.floor(column + 0.5) + shift, np.floor(line + 0.5) + shift
        points[count, 0], points[count, 1] = column, line
        count += 1
        # The first round writes the beginning of the first segment, each further one the end of a segment.
        if count > 1 and (last + 1 == end or not _follows(segments, last, last + 1)):
            break
        if count > 1:
            last += 1
        x, y = segments[last, 2], segments[last, 3]
    return count, count > 3 and _follows(segments, last, row)


@kernel
def _follows(segments: Floats, before: int, after: int) -> bool:
    """Return whether a segment begins where another one ends."""
    dx, dy = segments[after, 0] - segments[before, 2], segments[after, 1] - segments[before, 3]
    return bool(abs(dx) < GAP and abs(dy) < GAP)


@kernel
def snapping(segments: Floats, rows: tuple[int, int], n_discs: int, place: Floats, width: float) -> float:
    """Return the shift of lines that fill whole pixels; -1 if any line is not parallel to a row or column."""
    for row in range(rows[0], rows[0] + rows[1]):
        dx, dy = segments[row, 2] - segments[row, 0], segments[row, 3] - segments[row, 1]
        if abs(place[0] * dx + place[1] * dy) > ALIGNED and abs(place[3] * dx + place[4] * dy) > ALIGNED:
            return -1.0
    if n_discs > 0:
        return -1.0
    return 0.5 if int(width + 0.5) % 2 == 1 else 0.0


@kernel
def _add_circle(
    sheet: Rays, box: Ints, points: Floats, x: float, y: float, radius: float, width: float, style: int
) -> None:
    """Add the line of a circle [pixel]."""
    if style == SOLID or not radius * radius < MOST_CORNERS:
        add_disc(sheet, box, x, y, radius + 0.5 * width, 1.0)
        add_disc(sheet, box, x, y, radius - 0.5 * width, -1.0)
        return
    count = int(max(FINENESS * np.sqrt(radius), 12.0))
    for i in range(count):
        angle = 2.0 * np.pi * i / count
        points[i, 0], points[i, 1] = x + radius * np.cos(angle), y + radius * np.sin(angle)
    add_way(sheet, box, points, count, (width, style, 0.0), True, True)
