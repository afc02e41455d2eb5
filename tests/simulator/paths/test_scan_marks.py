"""Scans of one beam, marked in a grid of 10 x 4 cells of 1 m, worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.simulator.cell_paths.scan_marks import (
    OCCUPIED,
    PASSED,
    ROW,
    count_freed,
    free_passed,
    mark_hits,
    mark_passed,
    part_within,
)
from irsim_gym.simulator.paths.grid import Grid
from irsim_gym.simulator.world.own_scan import OwnScan

GRID = Grid(0.0, 0.0, 1.0, 10, 4)
RANGE = 5.0


def one_beam(reading: float) -> OwnScan:
    """Return the scan of a beam that looks straight ahead from its body's origin."""
    one, none = np.ones((1, 1)), np.zeros((1, 1))
    return OwnScan(
        sensors=np.zeros(1, np.int64),
        ranges=np.full((1, 1, 1), reading, np.float32),
        angles=none,
        beams_x=one,
        beams_y=none,
        offset=np.zeros((1, 3)),
        range_min=np.zeros(1),
        range_max=np.full(1, RANGE),
        noise=np.zeros(1),
    )


def free(cells: np.ndarray, reading: float, *pose: float) -> list[tuple[int, int]]:
    """Free what the beam passes, and return rows and columns of the quarters that were occupied."""
    doubted = np.zeros(64, np.int64)
    count = free_passed(one_beam(reading), 0, 0, np.array(pose), GRID, cells, doubted)
    return [divmod(int(number), ROW) for number in doubted[:count]]


def passed(reading: float, *pose: float) -> list[list[int]]:
    """Return rows and columns of the cells that the beam passes."""
    cells = np.zeros((4, 10), np.uint8)
    mark_passed(one_beam(reading), 0, 0, np.array(pose), GRID, cells)
    assert set(cells[cells != 0].tolist()) <= {int(PASSED)}
    return np.argwhere(cells).tolist()


def test_a_beam_frees_the_quarters_that_it_passes_and_no_others() -> None:
    """At y = 1.25 it passes the lower quarters of row 1; those of the upper half stay."""
    cells = np.zeros((4, 10), np.uint8)
    cells[1, 3] = cells[1, 7] = cells[2, 3] = OCCUPIED
    assert free(cells, RANGE, 0.5, 1.25, 0.0) == [(2, 6), (2, 7)]
    assert (cells[1, 3], cells[1, 7], cells[2, 3]) == (0b1100, OCCUPIED, OCCUPIED)


def test_the_quarter_that_is_hit_stays_occupied() -> None:
    """The beam ends at x = 3.75, in the right half of the cell."""
    cells = np.zeros((4, 10), np.uint8)
    cells[1, 3] = OCCUPIED
    assert free(cells, 3.25, 0.5, 1.25, 0.0) == [(2, 6)]
    assert cells[1, 3] == 0b1110


def test_a_steep_beam_marks_rows_as_a_flat_one_marks_columns() -> None:
    assert passed(2.5, 1.5, 1.5, 0.0) == [[1, 1], [1, 2], [1, 3], [1, 4]]
    assert passed(2.0, 1.5, 1.5, np.pi / 2) == [[1, 1], [2, 1], [3, 1]]
    cells = np.zeros((4, 10), np.uint8)
    cells[3, 1] = OCCUPIED
    assert sorted(free(cells, RANGE, 1.25, 0.5, np.pi / 2)) == [(6, 2), (7, 2)]
    assert cells[3, 1] == 0b1010


@pytest.mark.parametrize(
    "pose", [(-0.5, 1.25, 0.0), (10.25, 1.25, np.pi), (2.25, -0.5, np.pi / 2), (2.25, 4.25, -np.pi / 2)]
)
def test_a_sensor_outside_of_the_grid_marks_and_frees_nothing(pose: tuple[float, float, float]) -> None:
    cells = np.full((4, 10), OCCUPIED)
    assert free(cells, 2.5, *pose) == []
    assert (cells == OCCUPIED).all()
    assert passed(2.5, *pose) == []


@pytest.mark.parametrize(("pose", "doubted"), [((0.0, 1.25, 0.0), (2, 0)), ((2.25, 0.0, np.pi / 2), (0, 4))])
def test_a_sensor_on_the_lower_edges_is_inside(pose: tuple[float, float, float], doubted: tuple[int, int]) -> None:
    cells = np.zeros((4, 10), np.uint8)
    cells[doubted[0] // 2, doubted[1] // 2] = OCCUPIED
    assert doubted in free(cells, 2.0, *pose)
    assert [doubted[0] // 2, doubted[1] // 2] in passed(2.0, *pose)


def test_a_beam_is_cut_at_the_edges_of_the_grid() -> None:
    """From (1, 2) in a rectangle of 10 x 4: 9 to the right, 1 to the left, 2 up and down."""
    ends = [(18.0, 0.0), (-4.0, 0.0), (0.0, 8.0), (0.0, -4.0), (1.0, 1.0), (18.0, 8.0)]
    assert [part_within(1.0, 2.0, *end, 10.0, 4.0) for end in ends] == [0.5, 0.25, 0.25, 0.5, 1.0, 0.25]


def test_a_beam_that_begins_beyond_the_last_edge_has_no_length() -> None:
    """Just inside the grid, but beyond the edge at which beams are cut: never backwards."""
    assert part_within(10.0 - 5e-7, 1.5, 1e-8, 2.0, 10.0 - 1e-6, 4.0 - 1e-6) == 0.0


def test_quarters_that_the_scan_has_hit_again_were_not_freed() -> None:
    cells = np.zeros((4, 10), np.uint8)
    cells[1, 3] = 0b0001  # its lower left quarter
    numbers = np.array([2 * ROW + 6, 2 * ROW + 7, 3 * ROW + 6, 7 * ROW + 19])
    assert [count_freed(cells, numbers, n) for n in range(5)] == [0, 0, 1, 2, 3]


def test_a_hit_is_counted_once_and_skipped_if_asked() -> None:
    """A beam from (1.5, 1.5) ends at (4.75, 1.5): column 9 of row 3 among quarters, 20 in a row."""
    cells, fresh = np.zeros((4, 10), np.uint8), np.zeros(1, np.int32)
    scan, pose, none = one_beam(3.25), np.array([1.5, 1.5, 0.0]), np.zeros(0, np.bool_)
    assert mark_hits(scan, 0, 0, pose, GRID, cells, fresh, np.ones(1, np.bool_)) == 0
    assert not cells.any()
    assert mark_hits(scan, 0, 0, pose, GRID, cells, fresh, none) == 1
    assert (fresh[0], cells[1, 4]) == (3 * 20 + 9, 0b1000)
    assert mark_hits(scan, 0, 0, pose, GRID, cells, fresh, none) == 0
