"""Bounds on the distance from a map's cells, beside shapely."""

import numpy as np
import pytest
import shapely

from irsim_gym.simulator.cell_maps.cell_room import DOUBT, farthest, nearest_to_point2, room_about
from irsim_gym.simulator.cell_maps.cells import cells_are_closer, nearest_cell2, outline_near_cells
from tests.simulator.geometry.cell_maps import area, cell_map, random_map
from tests.simulator.geometry.shapes import disc


@pytest.mark.parametrize("share", [0.003, 0.05, 0.5])
def test_rooms_are_distances_of_the_centres(share: float) -> None:
    occupied = np.random.default_rng(8).random((40, 23)) < share
    room = cell_map(occupied, -1.0, 3.0, 0.3, 0.2).room
    i, j = np.meshgrid(np.arange(40), np.arange(23), indexing="ij")
    centres = shapely.points(-1.0 + 0.3 * (i + 0.5), 3.0 + 0.2 * (j + 0.5))
    true = shapely.distance(centres, area(occupied, -1.0, 3.0, 0.3, 0.2))
    assert room == pytest.approx(true, abs=1e-6)


def test_rooms_end_where_nobody_looks_farther() -> None:
    occupied = np.zeros((300, 2), np.bool_)
    occupied[0] = True
    cells = cell_map(occupied, 0.0, 0.0, 0.5, 1.0)
    room = cells.room
    assert farthest(cells) == 63.5 * 0.5
    assert room[:, 0].tolist() == [min(max(0.5 * k - 0.25, 0.0), 31.75) for k in range(300)]
    assert room_about(cells, 120.0, 1.0) == (pytest.approx(31.75 - np.hypot(0.25, 0.5), abs=1e-4), np.inf)
    assert room_about(cells, -0.1, 1.0) == (0.0, np.inf)


@pytest.mark.parametrize("seed", range(3))
def test_bounds_hold_and_decide_as_shapely_does(seed: int) -> None:
    cells, occupied = random_map(seed, (0.02, 0.1, 0.4)[seed])
    for x, y in np.random.default_rng(seed).uniform([0.8, 1.8], [6.3, 4.6], (400, 2)):
        least, most = room_about(cells, x, y)
        true = shapely.distance(occupied, shapely.Point(x, y))
        assert least <= true <= most
        assert most == np.inf or most - least <= np.hypot(0.3, 0.2) + 4 * DOUBT
        for limit in (0.1, 0.3, 0.7):
            assert cells_are_closer(cells, (x, y), limit) == (true < limit)
            assert outline_near_cells(cells, disc(x, y, 0.2).outline, limit) == (true < 0.2 + limit)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.1, 0.5])
def test_the_nearest_cell_to_a_point_is_that_of_the_plain_search(share: float) -> None:
    cells, occupied = random_map(11, share, 31, 25)
    for x, y in np.random.default_rng(12).uniform([-1, 0], [12, 9], (300, 2)):
        true = shapely.distance(occupied, shapely.Point(x, y)) if share > 0.0 else np.inf
        for reach in (0.05, 0.5, 3.0, 20.0):
            found = nearest_to_point2(cells, x, y, reach)
            if true <= reach:
                assert found == nearest_cell2(cells, x, y, x, y, reach, 0.0)
                assert found == pytest.approx(true * true, abs=1e-12)
            else:
                assert found == np.inf
