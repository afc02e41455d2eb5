import numpy as np
import pytest
import shapely

from irsim_gym.simulator.paths.clearance import way_is_free
from irsim_gym.simulator.paths.grid import Grid
from irsim_gym.simulator.paths.spread import LENGTHS, STEPS, VIA
from tests.simulator.paths.scenes import Scene, point, random_scene

RADIUS = 0.2


def test_grid_over_a_rectangle() -> None:
    assert Grid.over([1.0, 2.0, 3.0, 2.5], 0.25) == Grid(1.0, 2.0, 0.25, 8, 2)
    assert Grid.over([0.0, 0.0, 10.0, 7.0], 0.1).blocked().shape == (70, 100)


@pytest.mark.parametrize("width", [0.01, 0.3, 0.99, 1.0, 1.04, 1.06])
def test_centres_lie_within_the_rectangle(width: float) -> None:
    grid = Grid.over([5.0, 0.0, 5.0 + width, 1.0], 0.1)
    first, last = grid.origin_x + 0.05, grid.origin_x + (grid.columns - 0.5) * 0.1
    assert first + 1e-12 >= 5.0
    assert last <= 5.0 + width + 1e-12


@pytest.mark.parametrize(("seed", "cell"), [(seed, cell) for seed in range(8) for cell in (0.1, 0.25)])
def test_blocked_cells_against_shapely(seed: int, cell: float) -> None:
    scene = random_scene(seed, walled=seed % 2 == 0)
    grid, wide = scene.grid(cell), np.sqrt(RADIUS * RADIUS + 0.5 * cell * cell)
    columns, rows = np.meshgrid(np.arange(grid.columns), np.arange(grid.rows))
    centres = shapely.points(grid.origin_x + (columns + 0.5) * cell, grid.origin_y + (rows + 0.5) * cell)
    distance = shapely.distance(centres, scene.shape)
    clear = abs(distance - wide) > 2e-4  # shapely's discs are polygons, up to 0.1 mm too small
    found = scene.blocked(RADIUS, cell).astype(bool)
    assert np.array_equal(found[clear], (distance <= wide)[clear])
    assert clear.mean() > 0.99


def test_bodies_beyond_the_grid_do_no_harm() -> None:
    scene = Scene(2.0).disc(-5.0, 1.0, 1.0).box(9.0, -3.0, 12.0, 20.0).chain((-1e9, 40.0), (1e9, 41.0))
    assert not scene.blocked(RADIUS, 0.1).any()
    assert Scene(2.0).box(-5.0, -5.0, 9.0, 9.0).blocked(RADIUS, 0.1).all()


def test_bodies_that_do_not_block_are_ignored() -> None:
    scene = Scene(2.0).box(0.5, 0.5, 1.5, 1.5).disc(1.0, 1.0, 0.5)
    obstacles = scene.obstacles
    obstacles.blocks[:] = False
    assert way_is_free(obstacles, RADIUS, (0.0, 1.0), (2.0, 1.0))
    obstacles.blocks[1] = True
    assert not way_is_free(obstacles, RADIUS, (0.0, 1.0), (2.0, 1.0))
    assert way_is_free(obstacles, RADIUS, (0.29, 0.0), (0.29, 2.0))


def test_straight_ways_against_shapely() -> None:
    rng = np.random.default_rng(31)
    verdicts = []
    for seed in range(15):
        scene = random_scene(seed)
        obstacles, shape = scene.obstacles, scene.shape
        shapely.prepare(shape)
        ends = rng.uniform(0.0, 6.0, (100, 2, 2))
        ends[:50, 1] = ends[:50, 0] + rng.uniform(-0.5, 0.5, (50, 2))
        for (a, b), distance in zip(ends, shapely.distance(shapely.linestrings(ends), shape), strict=True):
            if abs(distance - RADIUS) > 2e-4:
                free = way_is_free(obstacles, RADIUS, point(a), point(b))
                assert free is bool(distance > RADIUS)
                verdicts.append(free)
    assert 0.1 < np.mean(verdicts) < 0.9


@pytest.mark.parametrize("seed", range(6))
def test_steps_between_free_cells_are_free(seed: int) -> None:
    """The certificate: wherever the grid says that a step is free, the exact test agrees."""
    scene, cell = random_scene(seed), 0.15
    grid, free = scene.grid(cell), scene.blocked(RADIUS, cell) == 0
    padded = np.pad(free, 2)
    rows, columns = np.nonzero(free)
    chosen = np.random.default_rng(seed).permutation(len(rows))[:120]
    for row, column in zip(rows[chosen], columns[chosen], strict=True):
        x, y = grid.origin_x + (column + 0.5) * cell, grid.origin_y + (row + 0.5) * cell
        for step, via in zip(STEPS, VIA, strict=True):
            needed = [step, *via]
            if all(padded[row + 2 + dy, column + 2 + dx] for dy, dx in needed):
                end = (x + step[1] * cell, y + step[0] * cell)
                assert way_is_free(scene.obstacles, RADIUS, (x, y), end)


def test_steps() -> None:
    assert len(STEPS) == 16
    assert sorted(set(np.round(LENGTHS**2).astype(int))) == [1, 2, 5]
    for step, via in zip(STEPS.tolist(), VIA.tolist(), strict=True):
        middle = np.array(step) / 2
        assert all(np.max(np.abs(np.array(cell) - middle)) <= 1.0 for cell in via)
        assert np.allclose(np.sum(via, axis=0), step)
