"""What scans have shown, in the cells of a grid: beams pass cells, and occupy those where they end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from irsim_gym.arraytypes import Bytes, Floats, Labels
from irsim_gym.jit import kernel
from irsim_gym.paths.clearance import Point
from irsim_gym.paths.grid import Grid
from irsim_gym.world.own_scan import OwnScan

UNKNOWN, PASSED, OCCUPIED, DOUBTED = np.uint8(0), np.uint8(1), np.uint8(2), np.uint8(3)
"""What is known of a cell; ``DOUBTED`` ones were occupied, and a beam of the present scan has passed them."""


class GridEye(NamedTuple):
    """A range sensor seen from a grid: x and y [cells], cosine and sine of its body's heading [cells / m]."""

    x: float
    y: float
    cosine: float
    sine: float


@kernel(inlined=True)
def eye_of(scan: OwnScan, k: int, pose: Floats, grid: Grid) -> GridEye:
    """Return where the sensor of member k is.

    Reads: scan (offset, sensors).
    """
    mount, scale = scan.offset[scan.sensors[k]], 1.0 / grid.cell
    cosine, sine = scale * np.cos(pose[2]), scale * np.sin(pose[2])
    x = scale * (pose[0] - grid.origin_x) + cosine * mount[0] - sine * mount[1]
    y = scale * (pose[1] - grid.origin_y) + sine * mount[0] + cosine * mount[1]
    return GridEye(x, y, cosine, sine)


@kernel(inlined=True)
def beam_end(scan: OwnScan, eye: GridEye, s: int, i: int, length: float) -> tuple[float, float]:
    """Return the point [cells] so far [m] along beam i of sensor s.

    Reads: scan (beams_x, beams_y).
    """
    x, y = length * scan.beams_x[s, i], length * scan.beams_y[s, i]
    return eye.x + eye.cosine * x - eye.sine * y, eye.y + eye.sine * x + eye.cosine * y


@kernel
def mark_passed(scan: OwnScan, w: int, k: int, pose: Floats, grid: Grid, cells: Bytes, doubted: Labels) -> int:
    """Mark the cells that the beams of a scan pass, without those where they hit; return how many are doubted.

    Beams that are not valid, and those of a sensor outside of the grid, pass nothing.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors).
    Writes: doubted.

    Args:
        scan: The scans.
        w: The world.
        k: The member.
        pose: Of its body [m, m, rad].
        grid: The grid.
        cells: What is known, shape ``(rows, columns)``.
        doubted: Written: numbers of cells that were occupied, room for all cells; with no room these stay as they are.
    """
    eye, s, count = eye_of(scan, k, pose, grid), scan.sensors[k], 0
    if not (0.0 <= eye.x < grid.columns and 0.0 <= eye.y < grid.rows):
        return 0
    readings, least, most = scan.ranges[w, s], np.float32(scan.range_min[s]), np.float32(scan.range_max[s])
    for i in range(readings.shape[0]):
        if readings[i] > least:
            x, y = beam_end(scan, eye, s, i, float(readings[i]))
            count = pass_cells((eye.x, eye.y), (x, y), readings[i] < most, cells, doubted, count)
    return count


@kernel(inlined=True)
def pass_cells(start: Point, end: Point, is_hit: bool, cells: Bytes, doubted: Labels, count: int) -> int:
    """Mark the cells from a point in the grid to another [cells], one after the other (Amanatides and Woo 1987).

    The last cell does not count if it is hit. What lies beyond the grid is left out.

    Writes: cells, doubted.
    """
    rows, columns = cells.shape
    dx, dy = end[0] - start[0], end[1] - start[1]
    # How much of the beam lies within the grid.
    part = min((columns - start[0]) / dx if dx > 0.0 else -start[0] / dx if dx < 0.0 else 1.0, 1.0)
    part = min((rows - start[1]) / dy if dy > 0.0 else -start[1] / dy if dy < 0.0 else 1.0, part)
    j, i = int(start[0]), int(start[1])
    left_x = min(max(int(start[0] + part * dx), 0), columns - 1) - j
    left_y = min(max(int(start[1] + part * dy), 0), rows - 1) - i
    jump_x, jump_y = (1 if left_x >= 0 else -1), (columns if left_y >= 0 else -columns)
    # Parts of the beam up to the next line between cells, and from one to the next.
    each_x, each_y = (1.0 / abs(dx) if left_x != 0 else 0.0), (1.0 / abs(dy) if left_y != 0 else 0.0)
    next_x = (j + 1 - start[0] if left_x > 0 else start[0] - j) * each_x
    next_y = (i + 1 - start[1] if left_y > 0 else start[1] - i) * each_y
    left_x, left_y = abs(left_x), abs(left_y)
    states, number = cells.reshape(-1), i * columns + j
    for _ in range(left_x + left_y + (0 if is_hit and part == 1.0 else 1)):
        known = states[number]
        states[number] = PASSED if known == UNKNOWN else known
        if known == OCCUPIED and doubted.shape[0] > 0:
            states[number] = DOUBTED
            doubted[count] = number
            count += 1
        is_x = (left_y == 0) | ((left_x > 0) & (next_x <= next_y))
        number += jump_x if is_x else jump_y
        next_x += each_x if is_x else 0.0
        next_y += 0.0 if is_x else each_y
        left_x -= 1 if is_x else 0
        left_y -= 0 if is_x else 1
    return count


@kernel
def mark_hits(scan: OwnScan, w: int, k: int, pose: Floats, grid: Grid, cells: Bytes, fresh: Labels) -> int:
    """Mark the cells in which the beams of a scan hit something; return how many were not known to be occupied.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors).
    Writes: cells, fresh.

    Args:
        scan: The scans.
        w: The world.
        k: The member.
        pose: Of its body [m, m, rad].
        grid: The grid.
        cells: What is known, shape ``(rows, columns)``.
        fresh: Written: the numbers of these cells, room for ``n_beams``.
    """
    eye, s, count = eye_of(scan, k, pose, grid), scan.sensors[k], 0
    readings, least, most = scan.ranges[w, s], np.float32(scan.range_min[s]), np.float32(scan.range_max[s])
    for i in range(readings.shape[0]):
        x, y = beam_end(scan, eye, s, i, float(readings[i]))
        if not (least < readings[i] < most and 0.0 <= x < grid.columns and 0.0 <= y < grid.rows):
            continue
        column, row = int(x), int(y)
        if cells[row, column] != OCCUPIED:
            if cells[row, column] != DOUBTED:
                fresh[count] = row * grid.columns + column
                count += 1
            cells[row, column] = OCCUPIED
    return count


@kernel
def settle_doubts(cells: Bytes, doubted: Labels, count: int) -> int:
    """Free the doubted cells that no beam of the scan has hit; return how many.

    Writes: cells.
    """
    columns, freed = cells.shape[1], 0
    for n in range(count):
        i, j = int(doubted[n]) // columns, int(doubted[n]) % columns
        if cells[i, j] == DOUBTED:
            cells[i, j] = PASSED
            freed += 1
    return freed
