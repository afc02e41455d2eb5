import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from irsim_gym.simulator.paths.geodesic import field_at
from irsim_gym.simulator.paths.grid import Grid
from irsim_gym.simulator.paths.points import PointMap, add_point
from tests.simulator.paths.scenes import Scene, random_points, random_scene, visibility_length

RADIUS = 0.2


def test_straight_is_exact() -> None:
    assert Scene().length(RADIUS, (1, 1), (4, 5)) == 5.0
    assert Scene().disc(1, 5, 0.5).length(RADIUS, (1, 1), (4, 5)) == 5.0
    assert Scene().length(RADIUS, (1, 1), (1, 1)) == 0.0


def test_no_way() -> None:
    fence = Scene().chain((2, 2), (4, 2), (4, 4), (2, 4), (2, 2))
    assert fence.length(RADIUS, (3, 3), (5, 5)) == np.inf
    assert Scene().box(2, 2, 4, 4).length(RADIUS, (3, 3), (5, 5)) == np.inf
    assert Scene().box(2, 2, 4, 4).length(RADIUS, (5, 5), (3.9, 4.15)) == np.inf


@pytest.mark.parametrize("seed", range(6))
def test_seen_points_are_in_the_way_as_discs_without_a_radius(seed: int) -> None:
    rng = np.random.default_rng(seed)
    seen, discs = Scene(points=PointMap.over([0.0, 0.0, 6.0, 6.0], 0.05, ())), Scene()
    # Walls of points with gaps, as scans show them.
    for x in rng.uniform(1.0, 5.0, 5).tolist():
        for y in (rng.uniform(0.0, 4.5) + np.arange(0.0, 1.5, 0.1)).tolist():
            add_point(seen.points, (x, y), (0.0, 0.0))
    for x, y in seen.points.places[np.isfinite(seen.points.places[..., 0])].astype(np.float64).tolist():
        discs.disc(x, y, 0.0)
    found = [scene.path(RADIUS, (0.5, 3.0), (5.5, 3.0)) for scene in (seen, discs)]
    assert len(found[0]) > 2, "no corner"
    assert np.array_equal(*found)


@pytest.mark.parametrize("reach", [0.5, 1.0, 2.0])
def test_around_the_tip_of_a_wall(reach: float) -> None:
    """Two tangents and an arc of the body's radius around the tip (3, 4); both ends are 2 m below it."""
    found = Scene().chain((3, -1), (3, 4)).length(RADIUS, (3 - reach, 2), (3 + reach, 2))
    apart = np.hypot(reach, 2.0)
    arc = 2.0 * (np.pi - np.arctan2(reach, 2.0) - np.arccos(RADIUS / apart))
    expected = 2.0 * np.sqrt(apart * apart - RADIUS * RADIUS) + RADIUS * arc
    assert expected <= found <= 1.002 * expected


def test_around_a_disc() -> None:
    """Two tangents and an arc about a disc of 1 m, midway between ends 4 m apart."""
    found = Scene().disc(3, 3, 1.0).length(RADIUS, (1, 3), (5, 3))
    arc = np.pi - 2.0 * np.arccos(1.2 / 2.0)
    expected = 2.0 * np.sqrt(4.0 - 1.44) + 1.2 * arc
    assert expected <= found <= 1.002 * expected


def test_out_of_a_trap() -> None:
    """A U that opens to the left: around the tip (1, 5) and the corner (4, 5); a point would go 8.4 m."""
    trap = Scene().chain((1, 1), (4, 1), (4, 5), (1, 5))
    found = trap.length(RADIUS, (3.7, 3), (4.3, 3))
    truth = visibility_length(trap, RADIUS, (3.7, 3), (4.3, 3))
    assert found > np.hypot(2.7, 2.0) + 3.0 + np.hypot(0.3, 2.0)
    assert truth <= found + 1e-6
    assert found <= 1.003 * truth


def test_against_a_visibility_graph() -> None:
    checked = 0
    for seed in range(60):
        scene, (start, goal) = random_scene(seed, 4), random_points(seed, 2)
        found = scene.length(RADIUS, start, goal)
        if found == np.hypot(*(goal - start)) or (found == np.inf and checked):
            continue
        truth = visibility_length(scene, RADIUS, start, goal)
        wide = visibility_length(scene, RADIUS + 0.06, start, goal)
        assert found >= truth - 1e-6
        assert found <= max(1.005 * truth, wide) + 1e-6
        checked += 1
        if checked == 8:
            break
    assert checked == 8


def test_paths_are_free_and_lead_from_start_to_goal() -> None:
    bent = 0
    for seed in range(60):
        scene, (start, goal) = random_scene(seed, 9), random_points(seed, 2)
        path = scene.path(RADIUS, start, goal)
        if len(path) == 0:
            continue
        assert (path[0] == start).all()
        assert (path[-1] == goal).all()
        assert shapely.distance(shapely.LineString(path), scene.shape) >= RADIUS - 1e-9
        bent += len(path) > 2
    assert bent >= 15


def test_reachable_means_finite_on_the_same_grid() -> None:
    for seed in range(60):
        scene, (start, goal) = random_scene(seed, 9), random_points(seed, 2)
        assert np.isfinite(scene.length(RADIUS, start, goal, 0.1)) == scene.reachable(RADIUS, start, goal, 0.1)


def test_both_directions_and_the_mirror_agree() -> None:
    for seed in range(30):
        scene, (start, goal) = random_scene(seed, 7), random_points(seed, 2)
        found = scene.length(RADIUS, start, goal)
        assert scene.length(RADIUS, goal, start) == pytest.approx(found, rel=0.03)
        flip = np.array([[6.0 - x, y] for x, y in (start, goal)])
        assert scene.mirrored().length(RADIUS, *flip) == pytest.approx(found, rel=0.03)


def test_field_without_obstacles_is_the_distance() -> None:
    _, at = Scene().field(RADIUS, (2.0, 3.0))
    for x, y in random_points(1, 200):
        true = np.hypot(x - 2.0, y - 3.0)
        assert true - 0.01 <= at(x, y) <= 1.028 * true + 0.15
    assert at(2.0, 3.0) <= 0.1


def test_field_against_shortest_paths() -> None:
    for seed in range(8):
        scene, points = random_scene(seed, 6), random_points(seed, 12)
        goal = next(point for point in points if scene.reachable(RADIUS, point, point))
        _, at = scene.field(RADIUS, goal)
        for x, y in points:
            length = scene.length(RADIUS, (x, y), goal, 0.1)
            if np.isfinite(length):
                assert 0.97 * length - 0.1 <= at(x, y) <= 1.03 * length + 0.4


def test_field_knows_where_there_is_no_way() -> None:
    scene = Scene().chain((2, 2), (4, 2), (4, 4), (2, 4), (2, 2))
    found, at = scene.field(RADIUS, (1.0, 1.0))
    assert at(3.0, 3.0) == np.inf
    assert np.isfinite(at(1.79, 3.0))
    assert found[10, 10] < 0.1
    blocked = scene.blocked(RADIUS, 0.1) == 1
    assert np.isfinite(found[blocked]).any()
    assert np.isinf(found[blocked]).any()


def test_field_is_continued_by_two_rings() -> None:
    scene = Scene().box(2, 2, 4, 4)
    found, _ = scene.field(RADIUS, (1.0, 1.0))
    blocked = scene.blocked(RADIUS, 0.1) == 1
    assert blocked[30].tolist() == [False] * 18 + [True] * 24 + [False] * 18
    assert np.isfinite(found[30]).tolist() == [True] * 20 + [False] * 20 + [True] * 20
    assert found[30, 18] <= found[30, 17] + 0.1 + 1e-12


def test_interpolation_by_hand() -> None:
    field, grid = np.array([[1.0, 2.0], [3.0, np.inf]]), Grid(10.0, 20.0, 2.0, 2, 2)
    assert field_at(field, grid, 11.0, 21.0) == 1.0
    assert field_at(field, grid, 12.0, 21.0) == 1.5
    assert field_at(field, grid, 12.0, 22.0) == 2.0  # the mean of the three that count
    assert field_at(field, grid, -5.0, 21.0) == 1.0  # beyond the outermost centres
    assert field_at(field, grid, 13.0, 23.0) == np.inf


def found_in_a_scene() -> list[Any]:
    """Return a length, what can be reached without and with a wall, a field and its value at the start."""
    scene = Scene(3.0).box(1.0, 1.0, 2.0, 1.4).disc(2.2, 2.2, 0.2).chain((0.2, 2.0), (1.2, 2.0))
    start, goal = (0.5, 0.5), (1.6, 2.6)
    field, at = scene.field(0.15, goal, 0.2)
    length, is_reached = scene.length(0.15, start, goal, 0.15), scene.reachable(0.15, start, goal, 0.15)
    behind = scene.chain((0.0, 1.7), (3.0, 1.7)).reachable(0.15, start, goal, 0.15)
    return [length, is_reached, behind, np.where(np.isfinite(field), field, -1.0).tolist(), at(0.5, 0.5)]


def test_compiled_agrees_with_plain_python() -> None:
    root = Path(__file__).parents[3]
    use = (
        "import json; from tests.simulator.paths import test_geodesic; "
        "print(json.dumps(test_geodesic.found_in_a_scene()))"
    )
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(root)}
    done = subprocess.run(
        [sys.executable, "-c", use], cwd=root, env=environment, capture_output=True, text=True, check=True
    )
    (length, yes, no, field, at), twin = found_in_a_scene(), json.loads(done.stdout.splitlines()[-1])
    assert (yes, no) == (True, False)
    assert (twin[1], twin[2]) == (True, False)
    assert twin[0] == pytest.approx(length, abs=1e-9)
    np.testing.assert_allclose(twin[3], field, atol=1e-12)
    assert twin[4] == pytest.approx(at, abs=1e-12)
