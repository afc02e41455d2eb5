"""Kernels that draw all items of a plan on a batch of pictures, from the lowest to the highest."""

from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Ints
from irsim_gym.rendering.raster import figures, records
from irsim_gym.rendering.raster.areas import add_line, add_polygon
from irsim_gym.rendering.raster.beams import load_beams, paint_hits, paint_scan
from irsim_gym.rendering.raster.figures import HIGH, LEFT, LOW, RIGHT
from irsim_gym.rendering.raster.masks import paint_fog, paint_image, paint_mask
from irsim_gym.rendering.raster.records import Look, Past, Prints, RasterCanvas, RasterOutline, RasterSource, Scratch
from irsim_gym.rendering.raster.sheets import paint
from irsim_gym.rendering.raster.ways import add_way, paint_outline
from irsim_gym.simulator.world.model import ROBOT, STATE
from irsim_gym.simulator.world.names import Model, State, kernel, row_of

LABEL_GAP = 0.08
"""Gap between a body and the label above it [m]."""


@kernel
def draw_items(
    pictures: Bytes, frames: Ints, worlds: Ints, items: Any, source: RasterSource, look: Look, scratch: Scratch
) -> None:
    """Draw the items of a plan on pictures.

    Args:
        pictures: uint8, shape ``(n, height, width, 3)``.
        frames: Which pictures, shape ``(n_drawn,)``.
        worlds: World of each picture, shape ``(n,)``.
        items: What is drawn, ``records.ITEM``.
        source: What is read of the simulation.
        look: Where the world is on the pictures; rows go by picture.
        scratch: Memory to draw with.
    """
    model, state, readings = source.model, source.state, source.readings
    for f in frames:
        w, picture, view = worlds[f], pictures[f], look.views[f]
        _find_struck(w, model, state, scratch)
        for item in items:
            kind, b, box = item.kind, item.body, look.boxes[f, item.box]
            if b >= 0 and not model.present[w, b]:
                continue
            canvas = RasterCanvas(picture, scratch.sheet, box)
            if kind in (records.SCAN, records.HITS):
                _draw_scan(canvas, item, source, w, f, view, scratch)
            elif kind in (records.GHOSTS, records.PATH):
                _draw_past(canvas, item, source, w, view, scratch)
            elif kind in (records.GOAL_CIRCLE, records.GOAL_MARKS):
                if model.has_goal[b]:
                    _draw_goal(canvas, item, source, w, view, scratch)
            elif kind == records.SHAPE:
                _draw_shape(canvas, item, source, w, view, scratch)
            elif kind == records.FOG:
                frame = scratch.colour
                columns, rows = readings.explored.shape[1], readings.explored.shape[2]
                frame[0], frame[1] = look.bounds[0], look.bounds[1]
                frame[2], frame[3] = (look.bounds[2] - frame[0]) / columns, (look.bounds[3] - frame[1]) / rows
                paint_fog(picture, box, readings.explored[w], scratch.cells, frame, view, item.colours[records.AREA])
            elif kind in (records.LABEL, records.GOAL_LABEL):
                if kind == records.LABEL or model.has_goal[b]:
                    _draw_label(picture, item, source, w, f, look, scratch)
            elif kind == records.FIELD:
                figures.paint_field(picture, scratch.sheet, box, scratch.points, item, state.pose[w, b], view)
            else:
                _draw_body(canvas, item, source, w, view, scratch)


@kernel
def _find_struck(w: int, model: Model, state: State, scratch: Scratch) -> None:
    """Mark the bodies that take part in a robot's collision.

    Reads: model (role), state (collided, hit).
    Writes: scratch.
    """
    n_bodies = scratch.struck.shape[0]
    for b in range(n_bodies):
        scratch.struck[b] = False
    for b in range(n_bodies):
        if model.role[b] == ROBOT and state.collided[w, b]:
            scratch.struck[b] = True
            if 0 <= state.hit[w, b] < n_bodies:
                scratch.struck[state.hit[w, b]] = True


@kernel
def _draw_body(canvas: RasterCanvas, item: Any, source: RasterSource, w: int, view: Floats, scratch: Scratch) -> None:
    """Draw a footprint, its shadow, image, heading or impact."""
    picture, _, box = canvas
    model, state, prints = source.model, source.state, source.prints
    b, kind, place = item.body, item.kind, scratch.place
    segment_rows = model.segment_start[b], model.segment_count[row_of(model.segment_count, w), b]
    disc_rows = model.disc_start[b], model.disc_count[row_of(model.disc_count, w), b]
    segments, discs = state.segments[w], state.discs[w]
    if kind in (records.HEADING, records.IMAGE):
        segments = model.local_segments[row_of(model.local_segments, w)]
        discs = model.local_discs[row_of(model.local_discs, w)]
        heading = state.pose[w, b, 2]
        if item.turns and (state.twist[w, b, 0] != 0.0 or state.twist[w, b, 1] != 0.0):
            heading = np.arctan2(state.twist[w, b, 1], state.twist[w, b, 0])
        figures.set_place(place, view, (state.pose[w, b, 0], state.pose[w, b, 1], heading))
    else:
        figures.set_place(place, view, (0.0, 0.0, 0.0))
    outline = RasterOutline(segments, segment_rows, discs, disc_rows)
    if kind == records.FOOTPRINT:
        figures.paint_footprint(canvas, scratch, item, outline, model.solid[b])
    elif kind == records.HEADING:
        count = figures.load_mark(scratch.points, item, outline, scratch.colour)
        figures.place_points(scratch.points, count, place)
        add_polygon(scratch.sheet, box, scratch.points, 0, count)
        paint(picture, scratch.sheet, box, item.colours[records.AREA], False)
    elif kind == records.SHADOW and (disc_rows[1] > 0 or (segment_rows[1] > 0 and model.solid[b])):
        place[2], place[5] = place[2] + item.x, place[5] + item.y
        inks, line = (item.colours[records.AREA], item.colours[records.EDGE]), (item.width, item.style, item.snapped)
        paint_outline(canvas, scratch.points, outline, place, inks, line)
    elif kind == records.IMPACT and scratch.struck[b]:
        scratch.colour[3] = 0.0
        inks = item.colours
        for width, colour in ((item.other_width, inks[records.OTHER]), (item.width, inks[records.EDGE])):
            line = width, item.style, item.snapped
            paint_outline(canvas, scratch.points, outline, place, (scratch.colour, colour), line)
    elif kind == records.IMAGE and figures.extent(scratch.colour, outline):
        points, low = scratch.points, scratch.colour
        points[0, 0], points[0, 1], points[1, 0], points[1, 1] = low[LEFT], low[LOW], low[RIGHT], low[LOW]
        points[2, 0], points[2, 1] = low[LEFT], low[HIGH]
        figures.place_points(points, 3, place)
        for i in range(1, 3):
            points[i, 0], points[i, 1] = points[i, 0] - points[0, 0], points[i, 1] - points[0, 1]
        paint_image(picture, box, prints.pixels, prints.image_rows, item.row, points[0], points[1], points[2])


@kernel
def _draw_past(canvas: RasterCanvas, item: Any, source: RasterSource, w: int, view: Floats, scratch: Scratch) -> None:
    """Draw the path or the past outlines of a body, beginning with the oldest."""
    model, past = source.model, source.past
    b, n_slots, count = item.body, past.noted.shape[1], 0
    # The slot of a step is its number modulo the number of slots, see ``simulator.readings.trails``.
    for step in range(_first_step(past, w, item), past.latest[w] + 1):
        if not _was_there(past, w, step, item):
            continue
        pose = past.poses[w, step % n_slots, item.row]
        if item.kind == records.PATH:
            scratch.points[count, 0], scratch.points[count, 1] = pose[0], pose[1]
            count += 1
        else:
            segment_rows = model.segment_start[b], model.segment_count[row_of(model.segment_count, w), b]
            disc_rows = model.disc_start[b], model.disc_count[row_of(model.disc_count, w), b]
            figures.set_place(scratch.place, view, (pose[0], pose[1], pose[2]))
            segments = model.local_segments[row_of(model.local_segments, w)]
            discs = model.local_discs[row_of(model.local_discs, w)]
            outline = RasterOutline(segments, segment_rows, discs, disc_rows)
            figures.paint_ghost(canvas, scratch, item, outline, model.solid[b])
    if item.kind == records.PATH:
        figures.paint_path(canvas.picture, scratch.sheet, canvas.box, scratch.points, item, count, view, scratch.colour)


@kernel
def _first_step(past: Past, w: int, item: Any) -> int:
    """Return the first step whose pose is shown."""
    latest = past.latest[w]
    first = max(latest - past.noted.shape[1] + 1, 0)
    if item.length > 0:
        count, step = 0, latest
        while step >= first and count < item.length:
            count += 1 if _was_there(past, w, step, item) else 0
            step -= 1
        first = step + 1
    return int(first)


@kernel
def _was_there(past: Past, w: int, step: int, item: Any) -> bool:
    """Return whether a step is shown and its pose was recorded."""
    slot = step % past.noted.shape[1]
    return bool(step % item.every == 0 and past.noted[w, slot] == step and past.poses[w, slot, item.row, 0] < np.inf)


@kernel
def _draw_scan(
    canvas: RasterCanvas, item: Any, source: RasterSource, w: int, f: int, view: Floats, scratch: Scratch
) -> None:
    """Draw the scan of a sensor, or the points that its beams hit."""
    scan, readings = source.scans[item.row], source.readings
    ranges, speeds, points = readings.ranges[f, scan.first :], readings.speeds[f, 0:], scratch.points
    if speeds.shape[0] > 0:
        speeds = speeds[scan.first :]
    load_beams(points, scan, source.state.pose[w, scan.body], readings.angles, ranges, 0, view)
    if item.kind == records.SCAN:
        paint_scan(canvas, points, item, scan, ranges, speeds, scratch.colour)
    else:
        paint_hits(canvas, points, item, scan, ranges, speeds, scratch.colour, source.prints)


@kernel
def _draw_goal(canvas: RasterCanvas, item: Any, source: RasterSource, w: int, view: Floats, scratch: Scratch) -> None:
    """Draw the circle of a goal, or its flag and the marks of the goals after it."""
    model, state, prints = source.model, source.state, source.prints
    b, goal = item.body, state.goal[w, item.body]
    threshold = model.goal_threshold[row_of(model.goal_threshold, w), b]
    if item.kind == records.GOAL_CIRCLE:
        arrived = state.arrived[w, b]
        figures.paint_goal(canvas, item, goal, threshold, arrived, view, scratch.colour)
    else:
        for i in range(state.waypoint[w, b] + 1, model.waypoint_count[w, b]):
            x, y = model.waypoints[w, b, i, 0], model.waypoints[w, b, i, 1]
            figures.paint_mark(canvas.picture, canvas.box, prints, item.every, x, y, view, item.colours[records.OTHER])
        x, y = goal[0], goal[1]
        for mask in range(item.row, item.row + 2):
            figures.paint_mark(canvas.picture, canvas.box, prints, mask, x, y, view, item.colours[records.EDGE])


@kernel
def _draw_shape(canvas: RasterCanvas, item: Any, source: RasterSource, w: int, view: Floats, scratch: Scratch) -> None:
    """Draw a shape of the table at its body or at the body's goal."""
    picture, sheet, box = canvas
    model, state, prints = source.model, source.state, source.prints
    b, points = item.body, scratch.points
    pose, heading = state.pose[w, b], 0.0
    if item.form == records.AT_GOAL:
        pose = state.goal[w, b]
        if not model.has_goal[b] or (item.turns and (model.arrive_mode[b] != STATE or np.isnan(pose[2]))):
            return
    if item.turns or item.form == records.AT_BODY:
        heading = pose[2]
    figures.set_place(scratch.place, view, (pose[0], pose[1], heading))
    threshold = model.goal_threshold[row_of(model.goal_threshold, w), b]
    figures.load_shape(points, item, prints.corners, threshold, scratch.place)
    if item.filled:
        add_polygon(sheet, box, points, 0, item.length)
        paint(picture, sheet, box, item.colours[records.AREA], False)
    if item.width > 0.0:
        add_way(sheet, box, points, item.length, (item.width, item.style, 0.0), item.snapped, True)
        paint(picture, sheet, box, item.colours[records.EDGE], False)


@kernel
def _draw_label(picture: Bytes, item: Any, source: RasterSource, w: int, f: int, look: Look, scratch: Scratch) -> None:
    """Draw a label: below a goal; above a body or at its given place, below the body if a flag is in the way."""
    model, state, prints = source.model, source.state, source.prints
    b, view, box = item.body, look.views[f], scratch.colour
    x, y, height = state.pose[w, b, 0], state.pose[w, b, 1], 1.3 * item.width / view[2]
    segment_rows = model.segment_start[b], model.segment_count[row_of(model.segment_count, w), b]
    disc_rows = model.disc_start[b], model.disc_count[row_of(model.disc_count, w), b]
    outline = RasterOutline(state.segments[w], segment_rows, state.discs[w], disc_rows)
    if item.kind == records.GOAL_LABEL:  # above the goal is its own flag
        below = model.goal_threshold[row_of(model.goal_threshold, w), b] + height
        x, y = state.goal[w, b, 0], state.goal[w, b, 1] - below
    elif item.in_metres:
        x, y = x + item.x, y + item.y
    elif figures.extent(box, outline):
        x, y = 0.5 * (box[LEFT] + box[RIGHT]), box[HIGH] + LABEL_GAP
        # The text is about 0.7 times as wide as its height times its number of letters.
        if _meets_flag(w, x, y, 0.35 * item.width * item.length / view[2], height, source, look, view):
            y = box[LOW] - height
    shown = look.boxes[f, records.PLOT]
    column, row = view[0] + view[2] * x, view[1] - view[2] * y
    if shown[0] <= column <= shown[2] and shown[1] <= row <= shown[3]:
        left, base = int(np.floor(column - item.half + 0.5)), int(np.floor(row - item.foot + 0.5))
        whole, ink = look.boxes[f, records.WHOLE], item.colours[records.AREA]
        paint_mask(picture, whole, prints.masks, prints.mask_rows, item.row, left, base, ink)


@kernel
def _meets_flag(
    w: int, x: float, y: float, half: float, height: float, source: RasterSource, look: Look, view: Floats
) -> bool:
    """Return whether a label over x, y [m] would overlap the flag of a goal."""
    model, state, meets = source.model, source.state, False
    for b in range(look.flagged.shape[0]):
        if look.flagged[b] and model.present[w, b] and model.has_goal[b]:
            goal_x, goal_y = state.goal[w, b, 0], state.goal[w, b, 1]
            beside = goal_x + look.flag[0] / view[2] < x - half or goal_x > x + half
            apart = goal_y + look.flag[1] / view[2] < y or goal_y > y + height
            meets = meets or not (beside or apart)
    return meets


@kernel
def draw_heads(
    pictures: Bytes, frames: Ints, words: Ints, ends: Ints, inks: Floats, prints: Prints, boxes: Ints
) -> None:
    """Draw words on pictures.

    Args:
        pictures: uint8, shape ``(n, height, width, 3)``.
        frames: Which pictures, shape ``(n_drawn,)``.
        words: Mask, column, row and colour of each word, shape ``(n_words, 4)``.
        ends: End of each picture's words, which follow those of the picture before, shape ``(n,)``.
        inks: Colours, shape ``(n_inks, 4)``.
        prints: Masks.
        boxes: Parts of the pictures, shape ``(n, 4, 4)``.
    """
    for f in frames:
        for i in range(0 if f == 0 else ends[f - 1], ends[f]):
            ink, box = inks[words[i, 3]], boxes[f, records.WHOLE]
            paint_mask(pictures[f], box, prints.masks, prints.mask_rows, words[i, 0], words[i, 1], words[i, 2], ink)


@kernel
def draw_frames(pictures: Bytes, frames: Ints, colours: Floats, width: float, look: Look, scratch: Scratch) -> None:
    """Tint the world's rectangle, or draw its edge if the width [pixel] is positive.

    Args:
        pictures: uint8, shape ``(n, height, width, 3)``.
        frames: Which pictures, shape ``(n_drawn,)``.
        colours: Colour and opacity for each picture, shape ``(n, 4)``.
        width: Width of the edge [pixel]; 0 tints the area.
        look: Where the world is.
        scratch: Memory to draw with.
    """
    for f in frames:
        if not colours[f, 3] > 0.0:
            continue
        view, points, bounds = look.views[f], scratch.points, look.bounds
        # A line of an odd width is sharp if it runs through the middle of pixels.
        shift = 0.5 if int(width + 0.5) % 2 == 1 else 0.0
        for i in range(4):
            x, y = bounds[0] if i in (0, 3) else bounds[2], bounds[1] if i < 2 else bounds[3]
            column, row = np.floor(view[0] + view[2] * x + 0.5), np.floor(view[1] - view[2] * y + 0.5)
            points[i, 0], points[i, 1] = column + shift, row + shift
        box = look.boxes[f, records.PLOT]
        if width > 0.0:
            add_line(scratch.sheet, box, points, 0, 4, width, True, True)
        else:
            add_polygon(scratch.sheet, box, points, 0, 4)
        paint(pictures[f], scratch.sheet, box, colours[f], False)
