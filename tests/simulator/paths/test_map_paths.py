"""Ways past the cells of a map: as past the same boxes, and as shapely says."""

import numpy as np
import pytest
import shapely

from irsim_gym.simulator.cell_paths.occupancy import mark_touched
from irsim_gym.simulator.paths.clearance import way_is_free
from tests.simulator.paths.scenes import Scene, point

RADIUS = 0.17


def random_cells(seed: int, share: float = 0.1) -> np.ndarray:
    return np.random.default_rng(seed).random((12, 9)) < share


def boxes(occupied: np.ndarray, size: float = 6.0) -> Scene:
    """Return a scene with a box in place of each occupied cell."""
    scene = Scene(size)
    width, height = size / occupied.shape[0], size / occupied.shape[1]
    for i, j in np.argwhere(occupied):
        scene.box(i * width, j * height, (i + 1) * width, (j + 1) * height)
    return scene


@pytest.mark.parametrize(("cell", "radius"), [(0.07, 0.0), (0.2, 0.0), (0.07, 0.08)])
def test_blocked_cells_against_shapely(cell: float, radius: float) -> None:
    scene = Scene().map(random_cells(1), radius).disc(3.0, 3.0, 0.4)
    grid = scene.grid(cell)
    wide = np.sqrt(RADIUS * RADIUS + 0.5 * cell * cell)
    columns, rows = np.meshgrid(np.arange(grid.columns), np.arange(grid.rows))
    centres = shapely.points(grid.origin_x + (columns + 0.5) * cell, grid.origin_y + (rows + 0.5) * cell)
    distance = shapely.distance(centres, scene.shape)
    clear = abs(distance - wide) > 2e-4
    assert np.array_equal(scene.blocked(RADIUS, cell).astype(bool)[clear], (distance <= wide)[clear])


def test_cells_that_discs_touch_against_shapely() -> None:
    scene, touched = Scene().map(random_cells(3, 0.1), 0.07), np.zeros((50, 41), np.bool_)
    mark_touched(scene.obstacles, 0.0, 0.0, 6.0 / 50, 6.0 / 41, touched)
    for i in range(50):
        for j in range(41):
            apart = shapely.box(i * 0.12, j * 6.0 / 41, (i + 1) * 0.12, (j + 1) * 6.0 / 41).distance(scene.area)
            if apart > 1e-6 or apart == 0.0:
                assert touched[i, j] == (apart == 0.0)


def test_cells_that_are_no_squares_and_touch_a_disc_against_shapely() -> None:
    scene, touched = Scene().disc(2.3, 3.1, 0.8), np.zeros((40, 12), np.bool_)
    mark_touched(scene.obstacles, 0.0, 0.0, 6.0 / 40, 6.0 / 12, touched)
    disc = shapely.Point(2.3, 3.1)
    for i in range(40):
        for j in range(12):
            gap = shapely.box(i * 0.15, j * 0.5, (i + 1) * 0.15, (j + 1) * 0.5).distance(disc) - 0.8
            assert touched[i, j] == (gap <= 0.0)


def touched_cells(scene: Scene, columns: int = 4, rows: int = 3) -> list[tuple[int, int]]:
    """Return columns and rows of the cells of 1 m that something touches."""
    touched = np.zeros((columns, rows), np.bool_)
    mark_touched(scene.obstacles, 0.0, 0.0, 1.0, 1.0, touched)
    return [(int(i), int(j)) for i, j in np.argwhere(touched)]


def test_cells_that_a_slanted_wall_touches() -> None:
    """It rises by 5 for each 9: y = 0.53 at x = 1, 1.08 at x = 2, and 1 at x = 1.85."""
    crossed = [(0, 0), (1, 0), (1, 1), (2, 1)]
    assert touched_cells(Scene().chain((0.5, 0.25), (2.75, 1.5))) == crossed
    assert touched_cells(Scene().chain((0.25, 0.5), (1.5, 2.75))) == [(0, 0), (0, 1), (1, 1), (1, 2)]


def test_cells_within_an_outline_are_touched_as_those_on_its_boundary() -> None:
    """The cells 0 and 3 of each axis hold the box's sides, of which the centres 0.5 and 3.5 lie outside."""
    inner = Scene().box(0.6, 0.6, 3.4, 3.4)
    assert touched_cells(inner, 5, 5) == [(i, j) for i in range(4) for j in range(4)]


def test_what_begins_before_the_grid_does_not_touch_its_other_end() -> None:
    assert touched_cells(Scene().disc(0.0, 0.0, 0.5)) == [(0, 0)]
    assert touched_cells(Scene().chain((-1.5, 1.5), (0.5, 1.5))) == [(0, 1)]
    assert touched_cells(Scene().chain((1.5, -1.5), (1.5, 0.5))) == [(1, 0)]
    assert touched_cells(Scene().disc(-2.0, 1.5, 0.5)) == []
    assert touched_cells(Scene().disc(4.0, 3.0, 0.5)) == [(3, 2)]


def test_a_map_wider_than_the_grid_blocks_what_lies_in_it() -> None:
    scene = Scene(2.0).map(np.ones((2, 2), np.bool_))
    scene.cells = scene.cells._replace(x=-5.0, y=-5.0, width=6.0, height=6.0)
    assert scene.blocked(RADIUS, 0.1).all()
    scene.cells = scene.cells._replace(x=50.0, y=-5.0)
    assert not scene.blocked(RADIUS, 0.1).any()


def test_straight_ways_against_shapely() -> None:
    rng = np.random.default_rng(7)
    scene = Scene().map(random_cells(2, 0.05))
    obstacles, verdicts = scene.obstacles, []
    for _ in range(300):
        a, b = rng.uniform(0.0, 6.0, (2, 2))
        apart = shapely.distance(shapely.LineString([a, b]), scene.shape)
        if abs(apart - RADIUS) > 1e-9:
            verdicts.append(apart > RADIUS)
            assert way_is_free(obstacles, RADIUS, point(a), point(b)) == verdicts[-1]
    assert 50 < sum(verdicts) < 250


@pytest.mark.parametrize("seed", range(6))
def test_ways_are_those_past_the_same_boxes(seed: int) -> None:
    """The two differ by rounding at most, which may tip a path to another way of nearly the same length."""
    occupied = random_cells(seed, 0.15)
    occupied[0, 0] = occupied[-1, -1] = False
    with_map, with_boxes = Scene().map(occupied), boxes(occupied)
    start, goal = (0.25, 0.33), (5.75, 5.67)
    assert with_map.reachable(RADIUS, start, goal) == with_boxes.reachable(RADIUS, start, goal)
    length = with_map.length(RADIUS, start, goal)
    assert length == pytest.approx(with_boxes.length(RADIUS, start, goal), rel=0.01)
    found, expected = with_map.field(RADIUS, goal)[0], with_boxes.field(RADIUS, goal)[0]
    assert np.allclose(found, expected, rtol=1e-9)
    path = with_map.path(RADIUS, start, goal)
    assert len(path) == 0 or shapely.distance(shapely.LineString(path), with_map.area) > RADIUS - 1e-9
