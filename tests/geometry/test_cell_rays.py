import numpy as np
import pytest
import shapely

from irsim_gym.geometry.cell_rays import cast_cells
from tests.geometry.cell_maps import cell_map, random_map

FAR = 5.0


def scan(cells, x: float, y: float, heading: float, angles, far: float = FAR):
    beams_x, beams_y = np.cos(angles).astype(np.float32), np.sin(angles).astype(np.float32)
    ranges = np.full(len(angles), far, np.float32)
    cast_cells(*cells[:2], x, y, heading, beams_x, beams_y, ranges)
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
