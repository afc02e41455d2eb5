import numpy as np
import pytest
import shapely

from irsim_gym.simulator.cell_maps.cell_rays import N_FLOATS, N_INTEGERS, cast_cells
from tests.simulator.geometry.cell_maps import area, cell_map, random_map

FAR = 5.0


def scan(cells, x: float, y: float, heading: float, angles, far: float = FAR):
    beams_x, beams_y = np.cos(angles).astype(np.float32), np.sin(angles).astype(np.float32)
    ranges = np.full(len(angles), far, np.float32)
    scratch = np.full(N_FLOATS, np.nan, np.float32), np.full(N_INTEGERS, -1, np.int32)
    cast_cells(cells, (x, y, heading), beams_x, beams_y, *scratch, ranges)
    return ranges


@pytest.mark.parametrize("seed", range(4))
def test_beams_against_shapely(seed: int) -> None:
    """From inside, outside and beyond the map: the nearest boundary of the occupied area."""
    cells, occupied = random_map(seed, (0.02, 0.1, 0.3, 0.6)[seed])
    boundary = occupied.boundary
    rng, angles = np.random.default_rng(seed), np.linspace(-3.1, 3.1, 40)
    for _ in range(40):
        x, y, heading = rng.uniform([0, 1, -3], [7, 6, 3])
        ranges = scan(cells, x, y, heading, angles)
        for k, angle in enumerate(angles + heading):
            beam = shapely.LineString([(x, y), (x + FAR * np.cos(angle), y + FAR * np.sin(angle))])
            met = beam.intersection(boundary)
            true = FAR if met.is_empty else shapely.distance(shapely.Point(x, y), met)
            assert ranges[k] == pytest.approx(true, abs=1e-5)


@pytest.mark.parametrize(("share", "radius"), [(0.05, 0.1), (0.4, 0.06), (0.8, 0.1)])
def test_beams_meet_discs_where_shapely_does(share: float, radius: float) -> None:
    occupied = np.random.default_rng(3).random((17, 12)) < share
    cells, discs = cell_map(occupied, 1.0, 2.0, 0.3, 0.2, radius), area(occupied, 1.0, 2.0, 0.3, 0.2, radius)
    rng, angles = np.random.default_rng(4), np.linspace(-3.1, 3.1, 25)
    for _ in range(40):
        x, y, heading = rng.uniform([0, 1, -3], [7, 6, 3])
        ranges, here = scan(cells, x, y, heading, angles), shapely.Point(x, y)
        edge = discs.boundary
        if discs.contains(here):  # to the edge of the disc that it begins in
            edge = next(one for one in shapely.get_parts(discs) if one.contains(here)).boundary
        for k, angle in enumerate(angles + heading):
            beam = shapely.LineString([(x, y), (x + FAR * np.cos(angle), y + FAR * np.sin(angle))])
            met = beam.intersection(edge)
            true = FAR if met.is_empty else shapely.distance(here, met)
            grazes = not met.is_empty and abs(shapely.distance(shapely.Point(x, y), met) - ranges[k]) > 1e-3
            if grazes:  # the polygon misses by its flat sides what the disc catches
                narrow = discs.buffer(1e-5).boundary.intersection(beam)
                true = shapely.distance(here, narrow)
            assert ranges[k] == pytest.approx(true, abs=1e-3)


def test_beams_along_the_axes() -> None:
    cells = cell_map([[0, 0, 0], [0, 0, 0], [1, 0, 1]], 0.0, 0.0, 2.0, 1.0)
    quarters = np.array([0.0, 0.5 * np.pi, np.pi, -0.5 * np.pi])
    assert scan(cells, 1.0, 0.5, 0.0, quarters).tolist() == [3.0, FAR, FAR, FAR]
    assert scan(cells, 5.0, 1.5, 0.0, quarters).tolist() == pytest.approx([FAR, 0.5, FAR, 0.5])
    # From within an occupied cell a beam ends where it leaves what is occupied.
    assert scan(cells, 5.0, 0.25, 0.0, quarters).tolist() == pytest.approx([1.0, 0.75, 1.0, 0.25])
    # On a boundary the cell that it looks into decides.
    assert scan(cells, 4.0, 0.5, 0.0, quarters[:1]).tolist() == [2.0]
    assert scan(cells, 4.0, 0.5, np.pi, quarters[:1]).tolist() == [FAR]


def test_what_is_nearer_stays() -> None:
    cells = cell_map([[0], [0], [1]])
    assert scan(cells, 0.5, 0.5, 0.0, np.zeros(1), far=1.0).tolist() == [1.0]
    assert scan(cells, 0.5, 0.5, 0.0, np.zeros(1), far=4.0).tolist() == [1.5]


def stepped(occupied, x: float, y: float, angle: float, width: float, height: float, far: float) -> float:
    """Return the range of one beam from a free cell: the textbook walk from cell to cell (Amanatides and Woo)."""
    place, end = [x / width, y / height], np.shape(occupied)
    speed = [np.cos(angle) / width, np.sin(angle) / height]
    cell = [int(np.floor(place[0])), int(np.floor(place[1]))]
    step = [1 if speed[axis] >= 0.0 else -1 for axis in (0, 1)]
    pace = [1.0 / abs(speed[axis]) for axis in (0, 1)]
    due = [(cell[a] + (step[a] > 0) - place[a]) * step[a] * pace[a] for a in (0, 1)]
    while True:
        axis = 0 if due[0] < due[1] else 1
        time = due[axis]
        cell[axis] += step[axis]
        due[axis] += pace[axis]
        if time >= far or not 0 <= cell[axis] < end[axis]:
            return far
        if occupied[cell[0], cell[1]]:
            return time


@pytest.mark.parametrize(("n_beams", "share"), [(1, 0.2), (31, 0.3), (32, 0.01), (33, 0.1), (100, 0.05)])
def test_blocks_of_beams_against_the_textbook_walk(n_beams: int, share: float) -> None:
    """Far ranges through many cells; a beam that grazes a corner may pass on either side of it."""
    rng = np.random.default_rng(n_beams)
    occupied = rng.random((300, 90)) < share
    cells, angles = cell_map(occupied, 0.0, 0.0, 0.2, 0.3), np.linspace(-np.pi, np.pi, n_beams)
    for i, j in rng.permutation(np.argwhere(~occupied))[:8]:
        x, y, heading = 0.2 * (i + rng.random()), 0.3 * (j + rng.random()), rng.uniform(-3.0, 3.0)
        ranges = scan(cells, x, y, heading, angles, far=30.0)
        for k, angle in enumerate(angles + heading):
            true = [stepped(occupied, x, y, angle + turn, 0.2, 0.3, 30.0) for turn in (0.0, 2e-6, -2e-6)]
            assert min(abs(ranges[k] - t) for t in true) < 2e-5


def test_a_map_without_occupied_cells_hides_nothing() -> None:
    assert scan(cell_map(np.zeros((4, 3))), 0.5, 0.5, 0.0, np.zeros(3)).tolist() == [FAR] * 3
