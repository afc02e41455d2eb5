"""What scans have shown, in the cells of a grid: beams pass cells, and occupy those where they end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from irsim_gym.arraytypes import Bytes, Floats, Labels
from irsim_gym.jit import kernel
from irsim_gym.paths.grid import Grid
from irsim_gym.world.own_scan import OwnScan

UNKNOWN, PASSED, OCCUPIED, DOUBTED = np.uint8(0), np.uint8(1), np.uint8(2), np.uint8(3)
"""What is known of a cell; ``DOUBTED`` ones were occupied, and a beam of the present scan has passed them."""


class CellBeam(NamedTuple):
    """A beam from a to b in cells, from the grid's lower left corner: columns x and rows y; whether it hits."""

    ax: float
    ay: float
    bx: float
    by: float
    is_hit: bool


@kernel
def beam_in_cells(scan: OwnScan, w: int, k: int, i: int, pose: Floats, grid: Grid) -> CellBeam:
    """Return beam i of member k as it lies in a grid; one whose reading is not valid has no length and hits nothing.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors).
    """
    s = scan.sensors[k]
    cosine, sine, reading = np.cos(pose[2]), np.sin(pose[2]), scan.ranges[w, s, i]
    is_valid = reading > np.float32(scan.range_min[s])
    length = float(reading) if is_valid else 0.0
    ahead, aside = scan.offset[s, 0], scan.offset[s, 1]
    x = (pose[0] + cosine * ahead - sine * aside - grid.origin_x) / grid.cell
    y = (pose[1] + sine * ahead + cosine * aside - grid.origin_y) / grid.cell
    along_x = cosine * scan.beams_x[s, i] - sine * scan.beams_y[s, i]
    along_y = sine * scan.beams_x[s, i] + cosine * scan.beams_y[s, i]
    reach = length / grid.cell
    is_hit = is_valid and reading < np.float32(scan.range_max[s])
    return CellBeam(x, y, x + reach * along_x, y + reach * along_y, is_hit)


@kernel
def mark_passed(scan: OwnScan, w: int, k: int, pose: Floats, grid: Grid, cells: Bytes, doubted: Labels) -> int:
    """Mark the cells that the beams of a scan pass, without those where they hit; return how many are doubted.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors).
    Writes: cells, doubted.

    Args:
        scan: The scans.
        w: The world.
        k: The member.
        pose: Of its body [m, m, rad].
        grid: The grid.
        cells: What is known, shape ``(rows, columns)``.
        doubted: Written: numbers of cells that were occupied, room for all cells; with no room these stay as they are.
    """
    count = 0
    for i in range(scan.ranges.shape[2]):
        count = pass_cells(beam_in_cells(scan, w, k, i, pose, grid), cells, doubted, count)
    return count


@kernel
def pass_cells(beam: CellBeam, cells: Bytes, doubted: Labels, count: int) -> int:
    """Mark the cells that a beam passes, one after the other (Amanatides and Woo 1987); return how many are doubted.

    The last cell counts unless the beam hits something in it.

    Writes: cells, doubted.
    """
    rows, columns = cells.shape
    dx, dy = beam.bx - beam.ax, beam.by - beam.ay
    j, i = int(np.floor(beam.ax)), int(np.floor(beam.ay))
    left_x, left_y = int(np.floor(beam.bx)) - j, int(np.floor(beam.by)) - i
    step_x, step_y = (1 if left_x >= 0 else -1), (1 if left_y >= 0 else -1)
    left_x, left_y = abs(left_x), abs(left_y)
    # Parts of the beam from one line between cells to the next, and to the first one.
    part_x, part_y = (1.0 / abs(dx) if left_x > 0 else 0.0), (1.0 / abs(dy) if left_y > 0 else 0.0)
    next_x = (j + 1 - beam.ax if step_x > 0 else beam.ax - j) * part_x if left_x > 0 else np.inf
    next_y = (i + 1 - beam.ay if step_y > 0 else beam.ay - i) * part_y if left_y > 0 else np.inf
    for _ in range(left_x + left_y + (0 if beam.is_hit else 1)):
        if 0 <= i < rows and 0 <= j < columns:
            if cells[i, j] == UNKNOWN:
                cells[i, j] = PASSED
            elif cells[i, j] == OCCUPIED and doubted.shape[0] > 0:
                cells[i, j] = DOUBTED
                doubted[count] = i * columns + j
                count += 1
        if next_x <= next_y:
            j, left_x = j + step_x, left_x - 1
            next_x = next_x + part_x if left_x > 0 else np.inf
        else:
            i, left_y = i + step_y, left_y - 1
            next_y = next_y + part_y if left_y > 0 else np.inf
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
    rows, columns = cells.shape
    count = 0
    for i in range(scan.ranges.shape[2]):
        beam = beam_in_cells(scan, w, k, i, pose, grid)
        column, row = int(np.floor(beam.bx)), int(np.floor(beam.by))
        if beam.is_hit and 0 <= row < rows and 0 <= column < columns and cells[row, column] != OCCUPIED:
            if cells[row, column] != DOUBTED:
                fresh[count] = row * columns + column
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
