import numpy as np
import pytest
import shapely

from irsim_gym.simulator.cell_maps.cells import (
    capsule_meets_cells,
    find_boxes,
    nearest_cell_point,
    outline_cells_distance,
    outline_meets_cells,
    outline_near_cells,
    segment_cells_distance,
)
from irsim_gym.simulator.cell_maps.world_maps import capsule_meets_map, map_is_closer, most_boxes, outline_near_map
from tests.simulator.geometry.cell_maps import cell_map, cell_maps, random_map
from tests.simulator.geometry.shapes import disc, linestring, polygon, random_shape

TOLERANCE = 1e-9
QUADRANTS = [(1, 1), (-1, 1), (1, -1), (-1, -1)]


def test_free_squares_are_the_largest() -> None:
    occupied = np.random.default_rng(1).random((9, 7)) < 0.15
    squares = cell_map(occupied).squares
    padded = np.pad(occupied, 300)
    for quadrant, (right, up) in enumerate(QUADRANTS):
        for i in range(9):
            for j in range(7):
                side = 0
                while side < 255:
                    columns = sorted((300 + i, 300 + i + right * side))
                    rows = sorted((300 + j, 300 + j + up * side))
                    if padded[columns[0] : columns[1] + 1, rows[0] : rows[1] + 1].any():
                        break
                    side += 1
                assert squares[quadrant, i, j] == side


def test_boxes_are_the_occupied_cells() -> None:
    occupied = np.random.default_rng(4).random((13, 8)) < 0.5
    boxes = np.zeros((most_boxes(13, 8), 4), np.int32)
    count = find_boxes(occupied, boxes)
    covered = np.zeros(occupied.shape, np.int64)
    for first_i, end_i, first_j, end_j in boxes[:count]:
        covered[first_i:end_i, first_j:end_j] += 1
    assert np.array_equal(covered, occupied)
    assert boxes[:count].tolist() == sorted(boxes[:count].tolist())
    assert find_boxes(occupied, boxes[:0]) == count  # without room it counts
    assert find_boxes(np.ones((3, 4), np.bool_), boxes) == 1
    assert boxes[0].tolist() == [0, 3, 0, 4]
    assert find_boxes(np.zeros((3, 4), np.bool_), boxes) == 0
    checkered = np.indices((5, 7)).sum(axis=0) % 2 == 0
    assert find_boxes(checkered, boxes) == 18 <= most_boxes(5, 7)  # one for each occupied cell


def test_capsules_against_shapely() -> None:
    rng = np.random.default_rng(2)
    met = 0
    for _ in range(1500):
        cells, occupied = MAPS[int(rng.integers(len(MAPS)))]
        a = rng.uniform([0, 1], [7, 6])
        b = a + rng.normal(size=2) * rng.choice([0.0, 0.3, 3.0])
        true = shapely.distance(occupied, shapely.LineString([a, b]))
        radius, limit = rng.choice([0.0, 0.05, 0.4]), rng.choice([0.1, 1.0, np.inf])
        if abs(true - radius) > TOLERANCE or true == 0.0:
            assert capsule_meets_cells(cells, *a, *b, radius) == (true <= radius)
        met += true <= radius
        assert segment_cells_distance(cells, *a, *b, limit) == pytest.approx(min(true, limit), abs=TOLERANCE)
    assert 200 < met < 1300


MAPS = [random_map(seed, share) for seed, share in enumerate((0.02, 0.1, 0.3, 0.6))]


def test_outlines_against_shapely() -> None:
    rng = np.random.default_rng(3)
    met = 0
    for _ in range(600):
        cells, occupied = MAPS[int(rng.integers(len(MAPS)))]
        shape = random_shape(rng)
        points = shape.segments.reshape(-1, 2)
        centre = rng.uniform([0.5, 1.5], [6.6, 4.9]) - (points.mean(axis=0) if len(points) else shape.discs[0, :2])
        shape = shape.moved(0.0, *centre)
        true = _distance(shape, occupied)
        outline = shape.outline
        if abs(true) > TOLERANCE or true == 0.0:
            assert outline_meets_cells(cells, outline) == (true <= 0.0)
        assert outline_cells_distance(cells, outline, np.inf) == pytest.approx(max(true, 0.0), abs=TOLERANCE)
        assert outline_cells_distance(cells, outline, 0.3) == pytest.approx(min(max(true, 0.0), 0.3), abs=TOLERANCE)
        met += true <= 0.0
    assert 100 < met < 550


def disc_map(seed: int, share: float, radius: float = 0.1):
    """Return a map with discs in oblong cells, and the middles of its occupied cells."""
    occupied = np.random.default_rng(seed).random((17, 12)) < share
    centres = [(1.0 + 0.3 * (i + 0.5), 2.0 + 0.2 * (j + 0.5)) for i, j in np.argwhere(occupied)]
    return cell_map(occupied, 1.0, 2.0, 0.3, 0.2, radius), shapely.MultiPoint(centres)


@pytest.mark.parametrize(("share", "radius"), [(0.02, 0.1), (0.3, 0.1), (0.3, 0.04), (0.9, 0.1)])
def test_discs_in_cells_against_shapely(share: float, radius: float) -> None:
    cells, centres = disc_map(5, share, radius)
    rng = np.random.default_rng(9)
    middles = shapely.points(*np.meshgrid(1.15 + 0.3 * np.arange(17), 2.1 + 0.2 * np.arange(12), indexing="ij"))
    assert cells.room == pytest.approx(np.maximum(shapely.distance(middles, centres) - radius, 0.0), abs=1e-6)
    for _ in range(400):
        a = rng.uniform([0, 1], [7, 6])
        b = a + rng.normal(size=2) * rng.choice([0.0, 0.3, 3.0])
        true = max(shapely.distance(centres, shapely.LineString([a, b])) - radius, 0.0)
        wide, limit = rng.choice([0.0, 0.05, 0.4]), rng.choice([0.1, 1.0, np.inf])
        if abs(true - wide) > TOLERANCE or true == 0.0:
            assert capsule_meets_cells(cells, *a, *b, wide) == (true <= wide)
        assert segment_cells_distance(cells, *a, *b, limit) == pytest.approx(min(true, limit), abs=TOLERANCE)
        gap, x, y = nearest_cell_point(cells, *a, np.inf)
        true = max(shapely.distance(centres, shapely.Point(a)) - radius, 0.0)
        assert gap == pytest.approx(true, abs=TOLERANCE)
        assert shapely.distance(centres, shapely.Point(x, y)) <= radius + TOLERANCE
        shape = random_shape(rng)
        points = shape.segments.reshape(-1, 2)
        shape = shape.moved(0.0, *(a - (points.mean(axis=0) if len(points) else shape.discs[0, :2])))
        true = max(_distance(shape, centres) - radius, 0.0)
        if true > TOLERANCE or _distance(shape, centres) < radius - TOLERANCE:
            assert outline_meets_cells(cells, shape.outline) == (true == 0.0)
        assert outline_cells_distance(cells, shape.outline, np.inf) == pytest.approx(true, abs=TOLERANCE)


def _distance(shape, occupied) -> float:
    parts = [shapely.distance(shapely.Point(x, y), occupied) - radius for x, y, radius in shape.discs]
    if len(shape.segments):
        lines = [shapely.LineString([row[:2], row[2:]]) for row in shape.segments]
        solid = shapely.unary_union(shapely.polygonize(lines)) if shape.solid else shapely.unary_union(lines)
        parts.append(shapely.distance(solid, occupied))
    return min(parts)


def test_touching_counts_and_blocks_have_no_holes() -> None:
    cells = cell_map([[0, 0, 0, 0], [0, 1, 1, 0], [0, 1, 1, 0], [0, 0, 0, 0]])
    assert outline_meets_cells(cells, disc(0.5, 2.0, 0.5).outline)
    assert not outline_meets_cells(cells, disc(0.5, 2.0, 0.499).outline)
    # A small disc where four occupied cells meet, which IR-SIM lets pass.
    assert outline_meets_cells(cells, disc(2.0, 2.0, 0.05).outline)
    assert outline_meets_cells(cells, linestring([[0.0, 3.0], [1.0, 3.0]]).outline)
    assert not outline_meets_cells(cells, linestring([[0.0, 3.01], [4.0, 3.01]]).outline)
    assert outline_cells_distance(cells, linestring([[0.0, 3.25], [4.0, 3.25]]).outline, 9.0) == 0.25


def test_an_area_around_cells_meets_them_and_a_line_does_not() -> None:
    cells = cell_map(np.pad([[True]], 3))
    corners = [[1.0, 1.0], [6.0, 1.0], [6.0, 6.0], [1.0, 6.0]]
    assert outline_meets_cells(cells, polygon(corners).outline)
    assert outline_cells_distance(cells, polygon(corners).outline, np.inf) == 0.0
    ring = linestring([*corners, corners[0]])
    assert not outline_meets_cells(cells, ring.outline)
    assert outline_cells_distance(cells, ring.outline, np.inf) == 2.0


def test_without_a_map_nothing_is_met() -> None:
    assert not capsule_meets_map(None, 0, 0.0, 0.0, 1.0, 1.0, 0.5)
    assert not map_is_closer(None, 0, (0.0, 0.0), 9.0)
    assert not outline_near_map(None, 0, disc(2.0, 0.5, 9.0).outline, 1.0)


def test_each_world_has_its_own_map() -> None:
    """A cell at (0, 0) in world 0, at (2, 1) in world 1; one map alone is that of every world."""
    occupied = np.zeros((2, 3, 2), np.bool_)
    occupied[0, 0, 0] = occupied[1, 2, 1] = True
    cells = cell_maps(occupied)
    assert [capsule_meets_map(cells, w, 0.5, 0.5, 0.5, 0.5, 0.1) for w in range(2)] == [True, False]
    assert [map_is_closer(cells, w, (2.5, 0.4), 0.7) for w in range(2)] == [False, True]
    assert [outline_near_map(cells, w, disc(1.5, 0.5, 0.4).outline, 0.2) for w in range(2)] == [True, False]
    assert capsule_meets_map(cell_maps(occupied[:1]), 7, 0.5, 0.5, 0.5, 0.5, 0.1)


def test_what_is_not_nearer_than_the_limit_is_the_limit() -> None:
    cells = cell_map(np.zeros((3, 2), np.bool_))
    for radius in np.random.default_rng(6).random(50):
        assert outline_cells_distance(cells, disc(1.0, 1.0, radius).outline, 0.05) == 0.05
        assert not outline_near_cells(cells, disc(1.0, 1.0, radius).outline, 0.05)


def test_near_is_closer_than_the_clearance() -> None:
    cells = cell_map([[1], [0], [0]])
    assert outline_near_cells(cells, disc(2.0, 0.5, 0.75).outline, 0.5)
    assert not outline_near_cells(cells, disc(2.0, 0.5, 0.75).outline, 0.25)
    assert outline_near_cells(cells, disc(2.0, 0.5, 1.0).outline, 0.0)
    assert not outline_near_cells(cells, disc(2.0, 0.5, 0.75).outline, 0.0)


def test_an_empty_map_is_infinitely_far() -> None:
    cells = cell_map(np.zeros((3, 2), np.bool_))
    assert outline_cells_distance(cells, disc(1.0, 1.0, 0.2).outline, np.inf) == np.inf
