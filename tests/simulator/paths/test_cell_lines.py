"""The nearest free cell, and straight lines over cells, worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.simulator.cell_paths.cell_lines import NEAR, free_cell, is_clear
from irsim_gym.simulator.paths.grid import BLOCKED, FREE, Grid

COLUMNS, ROWS = 44, 40
GRID = Grid(-1.0, 2.0, 0.5, COLUMNS, ROWS)


def middle(row: int, column: int) -> tuple[float, float]:
    return -1.0 + 0.5 * (column + 0.5), 2.0 + 0.5 * (row + 0.5)


@pytest.mark.parametrize(("up", "aside"), [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_a_free_cell_is_found_as_far_as_the_search_reaches(up: int, aside: int) -> None:
    row, column = 18, 20
    for distance, found in ((NEAR, True), (NEAR + 1, False)):
        cells = np.full((ROWS, COLUMNS), BLOCKED)
        there = row + up * distance, column + aside * distance
        cells[there] = FREE
        assert free_cell(GRID, cells, middle(row, column)) == (there[0] * COLUMNS + there[1] if found else -1)


def test_of_two_free_cells_the_nearer_one_is_found() -> None:
    """The point lies right of and above the middle of its cell."""
    cells = np.full((ROWS, COLUMNS), BLOCKED)
    x, y = middle(10, 10)
    cells[10, 7], cells[10, 13], cells[8, 10] = FREE, FREE, FREE
    assert free_cell(GRID, cells, (x, y)) == 8 * COLUMNS + 10
    cells[8, 10] = BLOCKED
    assert free_cell(GRID, cells, (x + 0.1, y)) == 10 * COLUMNS + 13
    assert free_cell(GRID, cells, (x - 0.1, y)) == 10 * COLUMNS + 7
    cells[13, 10] = FREE
    assert free_cell(GRID, cells, (x, y + 0.1)) == 13 * COLUMNS + 10


def test_the_edge_of_the_grid_bounds_the_search() -> None:
    cells = np.full((ROWS, COLUMNS), BLOCKED)
    cells[0, 0] = cells[ROWS - 1, COLUMNS - 1] = FREE
    assert free_cell(GRID, cells, middle(-2, -1)) == 0
    assert free_cell(GRID, cells, middle(ROWS, COLUMNS + 1)) == ROWS * COLUMNS - 1


def test_a_line_is_clear_along_rows_and_columns_that_are_free() -> None:
    cells = np.zeros((ROWS, COLUMNS), np.uint8)
    cells[5, 8] = BLOCKED
    assert not is_clear(middle(5, 3), middle(5, 12), GRID, cells)
    assert is_clear(middle(8, 3), middle(8, 12), GRID, cells)
    assert not is_clear(middle(2, 8), middle(9, 8), GRID, cells)
    assert is_clear(middle(2, 5), middle(9, 5), GRID, cells)
