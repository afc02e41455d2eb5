"""Kernels that paint readings of range sensors: the visible area, the beams, and the points that they hit."""

from typing import Any

import numpy as np

from irsim_gym.rendering.raster.areas import add_disc, add_polygon, is_near, paint_ring
from irsim_gym.rendering.raster.masks import paint_mask
from irsim_gym.rendering.raster.records import AREA, EDGE, Prints, RasterCanvas
from irsim_gym.rendering.raster.sheets import note, paint, scan_edge
from irsim_gym.simulator.world.names import Floats, Ints, Rays, kernel

MOST_BEAMS = 100
"""Only every n-th beam is drawn if there are more than this."""
HIT_MARGIN = 1e-3
"""A beam hits nothing if its range is within this of the maximum range [m]."""


@kernel
def load_beams(points: Floats, scan: Any, pose: Floats, angles: Floats, ranges: Rays, first: int, view: Floats) -> None:
    """Write the sensor's position as point 0 and the ends of its beams after it [pixel]."""
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    x, y = pose[0] + cosine * scan.x - sine * scan.y, pose[1] + sine * scan.x + cosine * scan.y
    points[0, 0], points[0, 1] = view[0] + view[2] * x, view[1] - view[2] * y
    for i in range(scan.count):
        angle, reach = angles[scan.first + i] + pose[2] + scan.heading, view[2] * float(ranges[first + i])
        points[i + 1, 0] = points[0, 0] + reach * np.cos(angle)
        points[i + 1, 1] = points[0, 1] - reach * np.sin(angle)


@kernel
def paint_scan(
    canvas: RasterCanvas, points: Floats, item: Any, scan: Any, ranges: Rays, speeds: Floats, colour: Floats
) -> None:
    """Paint a scan below the bodies: the visible area and the beams, or beams in the colours of radial velocities.

    ``points`` are those of ``load_beams``.
    """
    if not is_near(points, 0, 1):
        return
    if scan.coloured:
        _paint_velocities(canvas, points, item, scan, ranges, speeds, colour)
        return
    picture, sheet, box = canvas
    # A full turn is bounded by the ends of the beams alone; else the sensor is a corner, too.
    add_polygon(sheet, box, points, 1 if scan.surrounds else 0, scan.count if scan.surrounds else scan.count + 1)
    paint(picture, sheet, box, item.colours[AREA], False)
    apart = (scan.count + MOST_BEAMS - 1) // MOST_BEAMS
    for i in range(0, scan.count, apart):
        _add_beam(sheet, box, points, i + 1, item.width)
    paint(picture, sheet, box, item.colours[EDGE], False)


@kernel
def _add_beam(sheet: Rays, box: Ints, points: Floats, i: int, width: float) -> None:
    """Add the line from the sensor to point ``i``."""
    if not is_near(points, i, 1):
        return
    dx, dy = points[i, 0] - points[0, 0], points[i, 1] - points[0, 1]
    size = np.sqrt(dx * dx + dy * dy)
    if not size > 0.0:
        return
    across, down = -0.5 * width * dy / size, 0.5 * width * dx / size
    note(
        sheet, box, min(points[0, 0], points[i, 0]) - width, min(points[0, 1], points[i, 1]) - width,
        max(points[0, 0], points[i, 0]) + width, max(points[0, 1], points[i, 1]) + width,
    )  # fmt: skip
    x, y = points[0, 0] + across, points[0, 1] + down
    # The four sides of the thin rectangle around the beam: across at its end, back, and across at the sensor.
    for corner in range(4):
        middle = i if corner in (0, 1) else 0
        if corner in (1, 3):
            across, down = -across, -down
        next_x, next_y = points[middle, 0] + across, points[middle, 1] + down
        scan_edge(sheet, box, x, y, next_x, next_y)
        x, y = next_x, next_y


@kernel
def _paint_velocities(
    canvas: RasterCanvas, points: Floats, item: Any, scan: Any, ranges: Rays, speeds: Floats, colour: Floats
) -> None:
    """Paint all beams that hit nothing in one colour, and each other beam in the colour of its radial velocity."""
    picture, sheet, box = canvas
    for i in range(scan.count):
        if not (scan.range_min < ranges[i] < scan.range_max - HIT_MARGIN):
            _add_beam(sheet, box, points, i + 1, item.other_width)
    paint(picture, sheet, box, item.colours[AREA], False)
    for i in range(scan.count):
        if scan.range_min < ranges[i] < scan.range_max - HIT_MARGIN:
            _mix(colour, scan, speeds[i] if speeds.shape[0] else 0.0, item.colours[EDGE][3])
            _add_beam(sheet, box, points, i + 1, item.width)
            paint(picture, sheet, box, colour, False)


@kernel
def _mix(colour: Floats, scan: Any, speed: float, opacity: float) -> None:
    """Write the colour of a radial velocity: the colour of its sign, mixed with that of rest below full speed."""
    share = min(abs(speed) / scan.full_speed, 1.0)
    for channel in range(3):
        end = scan.away[channel] if speed >= 0.0 else scan.nearer[channel]
        colour[channel] = (1.0 - share) * scan.rest[channel] + share * end
    colour[3] = opacity


@kernel
def paint_hits(
    canvas: RasterCanvas,
    points: Floats,
    item: Any,
    scan: Any,
    ranges: Rays,
    speeds: Floats,
    colour: Floats,
    prints: Prints,
) -> None:
    """Paint the points that beams hit; ``load_beams`` writes ``points``."""
    picture, sheet, box = canvas
    for i in range(scan.count):
        x, y = points[i + 1, 0], points[i + 1, 1]
        if not (ranges[i] < scan.range_max - HIT_MARGIN and is_near(points, i + 1, 1)):
            continue
        if scan.full_speed <= 0.0:
            column, row = int(np.floor(x + 0.5)), int(np.floor(y + 0.5))
            paint_mask(picture, box, prints.masks, prints.mask_rows, item.every, column, row, item.colours[AREA])
        elif scan.mark > 0.0 and ranges[i] > scan.range_min:
            _mix(colour, scan, speeds[i] if speeds.shape[0] else 0.0, 1.0)
            add_disc(sheet, box, x, y, scan.mark, 1.0)
            paint(picture, sheet, box, colour, False)
            paint_ring(canvas, x, y, scan.mark, scan.mark_edge, scan.rim)
