"""Kernels that paint parts of bodies: footprints, headings, goals, fields of view, paths, and past outlines."""

from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Ints, Pose, Rays
from irsim_gym.base.kernels import kernel
from irsim_gym.rendering.raster import records
from irsim_gym.rendering.raster.areas import add_disc, add_line, add_polygon, paint_ring
from irsim_gym.rendering.raster.masks import paint_mask
from irsim_gym.rendering.raster.records import Prints, RasterCanvas, RasterOutline, Scratch
from irsim_gym.rendering.raster.sheets import paint
from irsim_gym.rendering.raster.ways import add_way, paint_outline

FADE_STEPS = 28
FAINTEST = 0.12
APART = 1.5
"""Points of a path that are closer than this along the path are left out [pixel]."""
ARC_STEP = 0.05
FULL_TURN = 2.0 * np.pi - 0.01
LEFT, RIGHT, LOW, HIGH = 0, 1, 2, 3


@kernel
def set_place(place: Floats, view: Floats, pose: Pose) -> None:
    """Write the transform from a frame at a pose [m, m, rad] to pixels; see ``ways.paint_outline``."""
    x, y, cosine, sine, scale = pose[0], pose[1], np.cos(pose[2]), np.sin(pose[2]), view[2]
    # Rows count downwards, so the second line has the opposite sign.
    place[0], place[1], place[2] = scale * cosine, -scale * sine, scale * x + view[0]
    place[3], place[4], place[5] = -scale * sine, -scale * cosine, view[1] - scale * y
    place[6] = scale


@kernel
def extent(box: Floats, outline: RasterOutline) -> bool:
    """Write the bounding box x_min, x_max, y_min, y_max of an outline [m]; return False for an empty one."""
    segments, segment_rows, discs, disc_rows = outline
    box[LEFT] = box[LOW] = np.inf
    box[RIGHT] = box[HIGH] = -np.inf
    for row in range(segment_rows[0], segment_rows[0] + segment_rows[1]):
        for end in range(0, 4, 2):
            box[LEFT], box[RIGHT] = min(box[LEFT], segments[row, end]), max(box[RIGHT], segments[row, end])
            box[LOW], box[HIGH] = min(box[LOW], segments[row, end + 1]), max(box[HIGH], segments[row, end + 1])
    for row in range(disc_rows[0], disc_rows[0] + disc_rows[1]):
        x, y, radius = discs[row, 0], discs[row, 1], discs[row, 2]
        box[LEFT], box[RIGHT] = min(box[LEFT], x - radius), max(box[RIGHT], x + radius)
        box[LOW], box[HIGH] = min(box[LOW], y - radius), max(box[HIGH], y + radius)
    return bool(box[LEFT] <= box[RIGHT])


@kernel
def paint_footprint(canvas: RasterCanvas, scratch: Scratch, item: Any, outline: RasterOutline, solid: bool) -> None:
    """Paint a footprint; one with several parts has no edges where the parts overlap."""
    n_segments, n_discs = outline.segment_rows[1], outline.disc_rows[1]
    is_area = item.filled and (n_discs > 0 or (n_segments > 0 and solid))
    area, nothing = item.colours[records.AREA], scratch.colour
    edge = item.colours[records.EDGE] if is_area else item.colours[records.OTHER]
    width = item.width if is_area else item.other_width
    nothing[3] = 0.0
    if not is_area:
        area = nothing
    elif area[3] >= 1.0 and (n_discs > 1 or n_discs * n_segments > 0):
        # Edges first, twice as wide: the areas then cover the inner half, and all of it where parts overlap.
        line = 2.0 * width, item.style, item.snapped
        paint_outline(canvas, scratch.points, outline, scratch.place, (nothing, edge), line)
        edge = nothing
    paint_outline(canvas, scratch.points, outline, scratch.place, (area, edge), (width, item.style, item.snapped))


@kernel
def load_mark(points: Floats, item: Any, outline: RasterOutline, box: Floats) -> int:
    """Write the corners of the mark that shows a body's heading, in the body's frame [m]; return their number."""
    if item.form == records.ARROW:
        neck, shaft, half = 0.55 * item.x, 0.14 * item.y, 0.5 * item.y
        points[0, 0], points[0, 1], points[1, 0], points[1, 1] = 0.0, shaft, neck, shaft
        points[2, 0], points[2, 1], points[3, 0], points[3, 1] = neck, half, item.x, 0.0
        points[4, 0], points[4, 1], points[5, 0], points[5, 1] = neck, -half, neck, -shaft
        points[6, 0], points[6, 1] = 0.0, -shaft
        return 7
    if not extent(box, outline):
        return 0
    if item.form == records.WINDSCREEN and outline.segment_rows[1] > 0:
        length, middle, half = box[RIGHT] - box[LEFT], 0.5 * (box[LOW] + box[HIGH]), 0.5 * (box[HIGH] - box[LOW])
        back, front = box[LEFT] + 0.56 * length, box[LEFT] + 0.74 * length
        points[0, 0], points[0, 1], points[1, 0], points[1, 1] = back, middle - 0.58 * half, front, middle - 0.76 * half
        points[2, 0], points[2, 1], points[3, 0], points[3, 1] = front, middle + 0.76 * half, back, middle + 0.58 * half
        return 4
    x, y, half = _centre(outline, box)
    points[0, 0], points[0, 1], points[1, 0], points[1, 1] = x + 0.70 * half, y, x - 0.46 * half, y + 0.50 * half
    points[2, 0], points[2, 1], points[3, 0], points[3, 1] = x - 0.20 * half, y, x - 0.46 * half, y - 0.50 * half
    return 4


@kernel
def _centre(outline: RasterOutline, box: Floats) -> tuple[float, float, float]:
    """Return the centre of a footprint and its distance to the boundary [m], of the first disc if there is one."""
    segments, segment_rows, discs, disc_rows = outline
    if disc_rows[1] > 0:
        return discs[disc_rows[0], 0], discs[disc_rows[0], 1], discs[disc_rows[0], 2]
    x, y, total, nearest2 = 0.0, 0.0, 0.0, np.inf
    for row in range(segment_rows[0], segment_rows[0] + segment_rows[1]):
        dx, dy = segments[row, 2] - segments[row, 0], segments[row, 3] - segments[row, 1]
        size = np.sqrt(dx * dx + dy * dy)
        x, y = x + size * (segments[row, 0] + 0.5 * dx), y + size * (segments[row, 1] + 0.5 * dy)
        total += size
    x, y = x / max(total, 1e-12), y / max(total, 1e-12)
    for row in range(segment_rows[0], segment_rows[0] + segment_rows[1]):
        dx, dy = segments[row, 2] - segments[row, 0], segments[row, 3] - segments[row, 1]
        share = ((x - segments[row, 0]) * dx + (y - segments[row, 1]) * dy) / max(dx * dx + dy * dy, 1e-12)
        share = min(max(share, 0.0), 1.0)
        dx, dy = segments[row, 0] + share * dx - x, segments[row, 1] + share * dy - y
        nearest2 = min(nearest2, dx * dx + dy * dy)
    # At least a part of the smaller extent, because the mean of the edges may lie near an edge, or outside.
    return x, y, max(np.sqrt(nearest2), 0.15 * min(box[RIGHT] - box[LEFT], box[HIGH] - box[LOW]))


@kernel
def place_points(points: Floats, count: int, place: Floats) -> None:
    """Transform points in a body's frame [m] to pixels."""
    for i in range(count):
        x, y = points[i, 0], points[i, 1]
        points[i, 0] = place[0] * x + place[1] * y + place[2]
        points[i, 1] = place[3] * x + place[4] * y + place[5]


@kernel
def load_around(points: Floats, form: int, outline: RasterOutline, box: Floats) -> bool:
    """Write a simpler shape around a footprint [m]: four corners of a rectangle, or centre and radius of a circle."""
    segments, segment_rows, discs, disc_rows = outline
    if not extent(box, outline):
        return False
    if form == records.RECTANGLE:
        for i in range(4):
            points[i, 0] = box[LEFT] if i in (0, 3) else box[RIGHT]
            points[i, 1] = box[LOW] if i < 2 else box[HIGH]
        return True
    x, y, reach = 0.5 * (box[LEFT] + box[RIGHT]), 0.5 * (box[LOW] + box[HIGH]), 0.0
    for row in range(segment_rows[0], segment_rows[0] + segment_rows[1]):
        for end in range(0, 4, 2):
            dx, dy = segments[row, end] - x, segments[row, end + 1] - y
            reach = max(reach, np.sqrt(dx * dx + dy * dy))
    for row in range(disc_rows[0], disc_rows[0] + disc_rows[1]):
        dx, dy = discs[row, 0] - x, discs[row, 1] - y
        reach = max(reach, np.sqrt(dx * dx + dy * dy) + discs[row, 2])
    points[0, 0], points[0, 1], points[1, 0] = x, y, reach
    return True


@kernel
def paint_ghost(canvas: RasterCanvas, scratch: Scratch, item: Any, outline: RasterOutline, solid: bool) -> None:
    """Paint a past outline of a body, or a simpler shape around it."""
    if item.form not in (records.CIRCLE, records.RECTANGLE):
        paint_footprint(canvas, scratch, item, outline, solid and item.form != records.CURVE)
        return
    picture, sheet, box = canvas
    points, place = scratch.points, scratch.place
    if not load_around(points, item.form, outline, scratch.colour):
        return
    if item.form == records.RECTANGLE:
        place_points(points, 4, place)
        if item.filled:
            add_polygon(sheet, box, points, 0, 4)
            paint(picture, sheet, box, item.colours[records.AREA], False)
        add_way(sheet, box, points, 4, (item.width, item.style, 0.0), True, True)
    else:
        radius = points[1, 0] * place[6]
        place_points(points, 1, place)
        if item.filled:
            add_disc(sheet, box, points[0, 0], points[0, 1], radius, 1.0)
            paint(picture, sheet, box, item.colours[records.AREA], False)
        add_disc(sheet, box, points[0, 0], points[0, 1], radius + 0.5 * item.width, 1.0)
        add_disc(sheet, box, points[0, 0], points[0, 1], radius - 0.5 * item.width, -1.0)
    paint(picture, sheet, box, item.colours[records.EDGE], False)


@kernel
def paint_field(picture: Bytes, sheet: Rays, box: Ints, points: Floats, item: Any, pose: Floats, view: Floats) -> None:
    """Paint a field of view: a sector, or a disc for a full turn (``item.x`` is its angle, ``item.y`` its depth)."""
    x, y, radius = view[0] + view[2] * pose[0], view[1] - view[2] * pose[1], view[2] * item.y
    if item.x >= FULL_TURN:
        add_disc(sheet, box, x, y, radius, 1.0)
        paint(picture, sheet, box, item.colours[records.AREA], False)
        add_disc(sheet, box, x, y, radius + 0.5 * item.width, 1.0)
        add_disc(sheet, box, x, y, radius - 0.5 * item.width, -1.0)
    else:
        count = max(int(item.x / ARC_STEP), 2) + 1
        points[0, 0], points[0, 1] = x, y
        for i in range(count):
            angle = pose[2] + item.x * (i / (count - 1) - 0.5)
            points[i + 1, 0], points[i + 1, 1] = x + radius * np.cos(angle), y - radius * np.sin(angle)
        add_polygon(sheet, box, points, 0, count + 1)
        paint(picture, sheet, box, item.colours[records.AREA], False)
        add_line(sheet, box, points, 0, count + 1, item.width, True, True)
    paint(picture, sheet, box, item.colours[records.EDGE], False)


@kernel
def paint_path(
    picture: Bytes, sheet: Rays, box: Ints, points: Floats, item: Any, count: int, view: Floats, colour: Floats
) -> None:
    """Paint the path of a body: a thin line that fades towards its beginning, or a band if the width is in metres.

    ``points`` holds its positions [m], with room for as many again.
    """
    count = _thin(points, count, view)
    if count < 2:
        return
    width = item.width * view[2] if item.in_metres else item.width
    steps = 1 if item.in_metres else FADE_STEPS
    # The path is cut into ``steps`` runs of equally many points. Only runs that have points count for the fading.
    n_parts, before = 0, 0
    for step in range(1, steps + 1):
        after = step * (count - 1) // steps
        n_parts += 1 if after > before else 0
        before = after
    part, before, length = 0, 0, 0.0
    for channel in range(3):
        colour[channel] = item.colours[records.EDGE][channel]
    for step in range(1, steps + 1):
        after = step * (count - 1) // steps
        if after == before:
            continue
        share = part / (n_parts - 1.0) if n_parts > 1 else 0.0
        faintest = 1.0 if item.in_metres else FAINTEST
        colour[3] = item.colours[records.EDGE][3] * (faintest + (1.0 - faintest) * share)
        # The run is copied behind all points, where ``add_way`` has room for dashes.
        for i in range(after - before + 1):
            points[count + i, 0], points[count + i, 1] = points[before + i, 0], points[before + i, 1]
        add_way(sheet, box, points[count:], after - before + 1, (width, item.style, length), False, False)
        paint(picture, sheet, box, colour, False)
        for i in range(before, after):
            dx, dy = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
            length += np.sqrt(dx * dx + dy * dy)
        part, before = part + 1, after


@kernel
def _thin(points: Floats, count: int, view: Floats) -> int:
    """Transform positions [m] to pixels and drop those that are too close to each other; return how many are left."""
    n_kept, along, last_x, last_y = 0, 0.0, 0.0, 0.0
    for i in range(count):
        x, y = view[0] + view[2] * points[i, 0], view[1] - view[2] * points[i, 1]
        before = np.floor(along / APART)
        if i > 0:
            along += np.sqrt((x - last_x) * (x - last_x) + (y - last_y) * (y - last_y))
        # Keeps the first point of each stretch of APART pixels, and both ends.
        if i == 0 or i == count - 1 or count < 3 or np.floor(along / APART) > before:
            points[n_kept, 0], points[n_kept, 1] = x, y
            n_kept += 1
        last_x, last_y = x, y
    return n_kept


@kernel
def paint_goal(
    canvas: RasterCanvas, item: Any, goal: Floats, threshold: float, arrived: bool, view: Floats, colour: Floats
) -> None:
    """Paint the circle of a goal's tolerance, with another fill once the body has arrived.

    A circle larger than ``filled_radius`` has a faint fill, so that the circles of many goals do not hide each other.
    """
    picture, sheet, box = canvas
    x, y, radius = view[0] + view[2] * goal[0], view[1] - view[2] * goal[1], view[2] * threshold
    add_disc(sheet, box, x, y, radius, 1.0)
    faint = min(1.0, item.filled_radius / max(radius, 1e-9))
    for channel in range(4):
        colour[channel] = item.colours[records.OTHER if arrived else records.AREA][channel]
    colour[3] *= faint * faint
    paint(picture, sheet, box, colour, False)
    paint_ring(canvas, x, y, radius, item.width, item.colours[records.EDGE])


@kernel
def load_shape(points: Floats, item: Any, corners: Floats, tolerance: float, place: Floats) -> None:
    """Write the corners of a shape in pixels; see ``records.Prints``.

    A corner that is not at the origin is at least ``item.x`` pixels away from it before its pixel offset is added.
    """
    scale = place[6]
    cosine, sine = place[0] / scale, -place[1] / scale
    for i in range(item.length):
        corner = corners[item.row + i]
        ahead, aside = scale * (corner[0] + tolerance * corner[2]), scale * (corner[1] + tolerance * corner[3])
        size = np.sqrt(ahead * ahead + aside * aside)
        if 0.0 < size < item.x:
            ahead, aside = ahead * item.x / size, aside * item.x / size
        ahead, aside = ahead + corner[4], aside + corner[5]
        points[i, 0] = place[2] + ahead * cosine - aside * sine
        points[i, 1] = place[5] - ahead * sine - aside * cosine


@kernel
def paint_mark(
    picture: Bytes, box: Ints, prints: Prints, mask: int, x: float, y: float, view: Floats, colour: Floats
) -> None:
    """Paint a mask with its origin at a point of the world [m]."""
    column, row = view[0] + view[2] * x, view[1] - view[2] * y
    if abs(column) < 1e6 and abs(row) < 1e6:
        left, top = int(np.floor(column + 0.5)), int(np.floor(row + 0.5))
        paint_mask(picture, box, prints.masks, prints.mask_rows, mask, left, top, colour)
