"""Marks scans in the cells of a grid: beams pass cells, and occupy a quarter of the cells where they end.

A cell is a byte: 0 while it is unknown, the bit ``PASSED``, and a bit for each occupied quarter.
"""

from typing import NamedTuple

import numpy as np

from irsim_gym.simulator.paths.grid import Grid
from irsim_gym.simulator.world.names import Bytes, Flags, Floats, Ints, Labels, OwnScan, Point, Rays, kernel

UNKNOWN, PASSED, OCCUPIED = np.uint8(0), np.uint8(16), np.uint8(15)
"""States of a cell: unknown, passed by a beam (bit 4), partly occupied (any of bits 0 to 3, one for each quarter)."""
BITS = 32
"""A doubted quarter is its column among all quarters, in the lowest bits, and its row in those above."""
ROW, EDGE = 1 << BITS, 1e-6
"""Difference between these numbers from row to row; how far inside the upper and right edge beams are cut [cells]."""


class GridEye(NamedTuple):
    """A range sensor seen from a grid: x and y [cells], cosine and sine of its body's heading [cells / m]."""

    x: float
    y: float
    cosine: float
    sine: float


class Line(NamedTuple):
    """The cells that a beam passes: both cells beside each row boundary that it crosses, and those of its ends.

    Between two such crossings, the beam crosses at most one column boundary. If the beam is not steep, rows and columns
    change places.

    Attributes:
        first: Index of the first cell, without its offset across.
        last: Index of the last cell.
        lines: Number of crossed boundaries.
        jump: Step of the index along the beam.
        aside: Step of the index across the beam.
        meets: Offset across of the first crossing [cells].
        each: Change of the offset from one crossing to the next [cells].
    """

    first: int
    last: int
    lines: int
    jump: int
    aside: int
    meets: float
    each: float


@kernel(inlined=True)
def eye_of(scan: OwnScan, k: int, pose: Floats, grid: Grid) -> GridEye:
    """Return where the sensor of member k is.

    Reads: scan (offset, sensors).
    """
    mount, scale = scan.offset[scan.sensors[k]], 1.0 / grid.cell
    # With the scale in the rotation, lengths in metres come out in cells.
    cosine, sine = scale * np.cos(pose[2]), scale * np.sin(pose[2])
    x = scale * (pose[0] - grid.origin_x) + cosine * mount[0] - sine * mount[1]
    y = scale * (pose[1] - grid.origin_y) + sine * mount[0] + cosine * mount[1]
    return GridEye(x, y, cosine, sine)


@kernel(inlined=True)
def beam_end(scan: OwnScan, eye: GridEye, s: int, i: int, length: float) -> Point:
    """Return the point [cells] on beam i of sensor s at a distance [m].

    Reads: scan (beams_x, beams_y).
    """
    x, y = length * scan.beams_x[s, i], length * scan.beams_y[s, i]
    return eye.x + eye.cosine * x - eye.sine * y, eye.y + eye.sine * x + eye.cosine * y


@kernel(inlined=True)
def quarter(row: int, column: int) -> np.uint8:
    """Return the bit of a quarter of a cell, by its row and column among all quarters."""
    return np.uint8(1 << (2 * (row & 1) + (column & 1)))


@kernel
def mark_passed(scan: OwnScan, w: int, k: int, pose: Floats, grid: Grid, cells: Bytes) -> None:
    """Mark the cells that the beams of a scan pass, including those in which they end.

    Beams that are not valid, and all beams of a sensor outside the grid, mark nothing.

    Reads: scan (beams_x, beams_y, offset, range_min, ranges, sensors).

    Args:
        scan: The scans.
        w: World.
        k: The member.
        pose: Of its body [m, m, rad].
        grid: The grid.
        cells: Changed: what is known, shape ``(rows, columns)``.
    """
    eye, s, states = eye_of(scan, k, pose, grid), scan.sensors[k], cells.reshape(-1)
    if not (0.0 <= eye.x < grid.columns and 0.0 <= eye.y < grid.rows):
        return
    readings, least = scan.ranges[w, s], np.float32(scan.range_min[s])
    for i in range(readings.shape[0]):
        if readings[i] > least:
            x, y = beam_end(scan, eye, s, i, float(readings[i]))
            line = line_between(eye.x, eye.y, x, y, grid.columns, grid.rows, grid.columns)
            # Each crossing below marks the cells on both sides of a boundary; the end alone may lie beyond all of them.
            states[line.last] |= PASSED
            number = line.first
            for n in range(line.lines):
                # `number` counts along the beam. The offset across is that of the n-th crossing.
                quarter = number + int(line.meets + n * line.each) * line.aside
                number += line.jump
                states[quarter] |= PASSED
                states[quarter + line.jump] |= PASSED


@kernel(inlined=True)
def line_between(x: float, y: float, to_x: float, to_y: float, columns: int, rows: int, row: int) -> Line:
    """Return the cells between two points [cells] of a grid, whose indices grow by ``row`` from row to row.

    Cells outside the grid are left out.
    """
    dx, dy = to_x - x, to_y - y
    if not (0.0 <= to_x < columns - EDGE and 0.0 <= to_y < rows - EDGE):
        part = part_within(x, y, dx, dy, columns - EDGE, rows - EDGE)
        dx, dy = part * dx, part * dy
    # Major axis: the one along which the beam goes farther. It crosses at most one minor boundary per major one.
    is_steep = abs(dy) > abs(dx)
    along, aside = (row, 1) if is_steep else (1, row)
    major, minor = (y, x) if is_steep else (x, y)
    far, side = (dy, dx) if is_steep else (dx, dy)
    begin, end, ahead = int(major), int(major + far), (1 if far >= 0.0 else -1)
    slope = side / far if far != 0.0 else 0.0
    # Where the beam meets the first boundary of the major axis: at `begin` going back, at `begin + 1` going ahead.
    meets = minor + (begin + (1 if far >= 0.0 else 0) - major) * slope
    last = end * along + int(minor + side) * aside
    return Line(begin * along, last, abs(end - begin), ahead * along, aside, meets, ahead * slope)


@kernel(inlined=True)
def part_within(x: float, y: float, dx: float, dy: float, high_x: float, high_y: float) -> float:
    """Return the share of a beam, from a point in the grid [cells], that lies in the grid."""
    part = 1.0
    if not 0.0 <= x + dx < high_x:
        part = ((high_x if dx > 0.0 else 0.0) - x) / dx
    if not 0.0 <= y + dy < high_y:
        part = min(part, ((high_y if dy > 0.0 else 0.0) - y) / dy)
    return max(part, 0.0)


@kernel
def free_passed(scan: OwnScan, w: int, k: int, pose: Floats, grid: Grid, cells: Bytes, doubted: Ints) -> int:
    """Free the quarters that the beams of a scan pass, without those where they hit; return how many were occupied.

    A beam frees quarters only as far as the beams beside it reach, too. Alone, it would free the quarters along a wall
    that it grazes, because the wall lies in only a part of them.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors).
    Writes: cells, doubted.

    Args:
        scan: The scans.
        w: World.
        k: The member.
        pose: Of its body [m, m, rad].
        grid: The grid.
        cells: Changed: what is known, shape ``(rows, columns)``.
        doubted: Written: the quarters that were occupied, room for all.
    """
    eye, s, count, columns, rows = eye_of(scan, k, pose, grid), scan.sensors[k], 0, 2 * grid.columns, 2 * grid.rows
    if not (0.0 <= eye.x < grid.columns and 0.0 <= eye.y < grid.rows):
        return 0
    readings, least, most = scan.ranges[w, s], np.float32(scan.range_min[s]), np.float32(scan.range_max[s])
    for i in range(readings.shape[0]):
        length = least_beside(readings, i)
        if length > least:
            x, y = beam_end(scan, eye, s, i, float(length))
            line = line_between(eye.x, eye.y, x, y, grid.columns, grid.rows, grid.columns)
            # The quarters up to the first occupied cell are skipped. That cell may begin at the boundary before the
            # one that is counted, and before the n-th boundary, from 0 on, a beam crosses at least 2 n of quarters.
            skipped = max(2 * count_empty(line, cells) - 2, 0)
            line = line_between(2.0 * eye.x, 2.0 * eye.y, 2.0 * x, 2.0 * y, columns, rows, ROW)
            is_hit = length < most and 0.0 <= x < grid.columns and 0.0 <= y < grid.rows
            # The quarter at the end of a hit stays occupied; where nothing is hit, none does (-1).
            hit, number = (line.last if is_hit else -1), line.first + skipped * line.jump
            count = free_quarter(line.last, hit, cells, doubted, count)
            for n in range(skipped, line.lines):
                quarter = number + int(line.meets + n * line.each) * line.aside
                number += line.jump
                count = free_quarter(quarter, hit, cells, doubted, count)
                count = free_quarter(quarter + line.jump, hit, cells, doubted, count)
    return count


@kernel(inlined=True)
def least_beside(readings: Rays, i: int) -> np.float32:
    """Return the least of the readings of beam i and the beams beside it [m]."""
    return min(readings[max(i - 1, 0)], readings[i], readings[min(i + 1, readings.shape[0] - 1)])


@kernel(inlined=True)
def count_empty(line: Line, cells: Bytes) -> int:
    """Return the number of cell boundaries that a beam crosses before one beside an occupied cell."""
    states, number = cells.reshape(-1), line.first
    for n in range(line.lines):
        quarter = number + int(line.meets + n * line.each) * line.aside
        number += line.jump
        if (states[quarter] | states[quarter + line.jump]) & OCCUPIED != 0:
            return n
    return line.lines


@kernel(inlined=True)
def free_quarter(number: int, hit: int, cells: Bytes, doubted: Ints, count: int) -> int:
    """Free a quarter, unless it is the one to keep; list it if it was occupied; return the length of the list.

    Writes: cells, doubted.
    """
    row, column = number >> BITS, number & (ROW - 1)
    i, j, bit = row >> 1, column >> 1, quarter(row, column)
    if cells[i, j] & bit != 0 and number != hit:
        # The bit is set, so this clears it.
        cells[i, j] ^= bit
        doubted[count] = number
        count += 1
    return count


@kernel
def mark_hits(
    scan: OwnScan, w: int, k: int, pose: Floats, grid: Grid, cells: Bytes, fresh: Labels, skipped: Flags
) -> int:
    """Mark the quarters in which the beams of a scan hit something; return how many were not known to be occupied.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors).
    Writes: cells, fresh.

    Args:
        scan: The scans.
        w: World.
        k: The member.
        pose: Of its body [m, m, rad].
        grid: The grid.
        cells: Changed: what is known, shape ``(rows, columns)``.
        fresh: Written: the numbers of these quarters, row by row in twice as many columns, room for ``n_beams``.
        skipped: Whether the hit of each beam is left out, shape ``(n_beams,)``; of no length if none is.
    """
    eye, s, count = eye_of(scan, k, pose, grid), scan.sensors[k], 0
    readings, least, most = scan.ranges[w, s], np.float32(scan.range_min[s]), np.float32(scan.range_max[s])
    for i in range(readings.shape[0]):
        x, y = beam_end(scan, eye, s, i, float(readings[i]))
        if not (least < readings[i] < most and 0.0 <= x < grid.columns and 0.0 <= y < grid.rows):
            continue
        if i < skipped.shape[0] and skipped[i]:
            continue
        column, row = int(2.0 * x), int(2.0 * y)
        bit = quarter(row, column)
        if cells[row >> 1, column >> 1] & bit == 0:
            cells[row >> 1, column >> 1] |= bit
            fresh[count] = row * 2 * grid.columns + column
            count += 1
    return count


@kernel
def count_freed(cells: Bytes, doubted: Ints, count: int) -> int:
    """Return how many of the doubted quarters the scan has not hit."""
    freed = 0
    for n in range(count):
        row, column = doubted[n] >> BITS, doubted[n] & (ROW - 1)
        freed += 1 if cells[row >> 1, column >> 1] & quarter(row, column) == 0 else 0
    return freed
