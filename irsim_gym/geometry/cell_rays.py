"""Beams in an occupancy map: a walk from free square to free square, exact at every cell's boundary.

Where a beam stands in a free cell, the largest free square that has this cell in its corner and grows the way the
beam looks holds nothing that it could hit; so it may go on to where it leaves that square.
"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Bytes, Floats, Rays
from irsim_gym.jit import kernel

STEEP = 1e30
"""Cells per metre of a beam that does not move along an axis, inverted."""


@kernel
def cast_cells(
    frame: Floats,
    squares: Bytes,
    x: float,
    y: float,
    heading: float,
    beams_x: Rays,
    beams_y: Rays,
    ranges: Rays,
) -> None:
    """Shorten ``ranges`` to the nearest occupied cell; from within one, to where the beam leaves what is occupied.

    Args:
        frame: See ``cells``.
        squares: See ``cells``.
        x: The sensor's position [m].
        y: The sensor's position [m].
        heading: The sensor's heading [rad].
        beams_x: Unit directions in the sensor frame, at least as many as ranges.
        beams_y: As ``beams_x``.
        ranges: Changed: ranges [m], shape ``(n_beams,)``; what lies farther is not looked for.
    """
    cosine, sine = np.cos(heading), np.sin(heading)
    across, up = (x - frame[0]) / frame[2], (y - frame[1]) / frame[3]
    for k in range(ranges.shape[0]):
        east = (cosine * beams_x[k] - sine * beams_y[k]) / frame[2]
        north = (sine * beams_x[k] + cosine * beams_y[k]) / frame[3]
        ranges[k] = np.float32(walk(squares, across, up, east, north, np.float64(ranges[k])))


@kernel
def walk(squares: Bytes, x: float, y: float, east: float, north: float, far: float) -> float:
    """Return the time at which a point meets an occupied cell, or leaves those that it begins in; at most ``far``.

    Args:
        squares: See ``cells``.
        x: Position [cells].
        y: Position [cells].
        east: Velocity [cells per unit of time].
        north: Velocity [cells per unit of time].
        far: Longest time.
    """
    columns, rows = squares.shape[1], squares.shape[2]
    slow_x = 1.0 / east if abs(east) > 1.0 / STEEP else STEEP
    slow_y = 1.0 / north if abs(north) > 1.0 / STEEP else STEEP
    time = entry(x, y, slow_x, slow_y, float(columns), float(rows))
    if time >= far:
        return far
    step_x, step_y = 1 if east >= 0.0 else -1, 1 if north >= 0.0 else -1
    quadrant = (0 if step_x > 0 else 1) + (0 if step_y > 0 else 2)
    i = first_cell(x + time * east, step_x, columns)
    j = first_cell(y + time * north, step_y, rows)
    inside = time == 0.0 and squares[0, i, j] == 0
    while time < far:
        free = int(squares[quadrant, i, j])
        if (free == 0) != inside:
            return time
        reach = 1 if inside else free
        to_i, to_j = i + step_x * reach, j + step_y * reach
        time_x = ((to_i if step_x > 0 else to_i + 1) - x) * slow_x
        time_y = ((to_j if step_y > 0 else to_j + 1) - y) * slow_y
        if time_x < time_y:
            time = max(time, time_x)
            along = int(np.floor(y + time * north))
            i, j = to_i, min(max(along, j), to_j - 1) if step_y > 0 else max(min(along, j), to_j + 1)
        else:
            time = max(time, time_y)
            along = int(np.floor(x + time * east))
            j, i = to_j, min(max(along, i), to_i - 1) if step_x > 0 else max(min(along, i), to_i + 1)
        if i < 0 or j < 0 or i >= columns or j >= rows:
            return min(time, far) if inside else far
    return far


@kernel
def entry(x: float, y: float, slow_x: float, slow_y: float, columns: float, rows: float) -> float:
    """Return the time at which a point enters the map: 0 if it is within, inf if it never does."""
    if 0.0 <= x < columns and 0.0 <= y < rows:
        return 0.0
    left, right = -x * slow_x, (columns - x) * slow_x
    low, high = -y * slow_y, (rows - y) * slow_y
    enter = max(min(left, right), min(low, high), 0.0)
    leave = min(max(left, right), max(low, high))
    return enter if enter < leave else np.inf


@kernel
def first_cell(place: float, step: int, count: int) -> int:
    """Return the cell of ``count`` that a point lies in; on a boundary the one that it moves into."""
    cell = np.floor(place) if step > 0 else np.ceil(place) - 1.0
    return int(min(max(cell, 0.0), count - 1.0))
