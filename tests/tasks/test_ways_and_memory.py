"""free_travel, goal_record and trail against values worked out by hand."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from task_tools import ROBOT, drive, play

from irsim_gym.tasks import Episodes
from irsim_gym.tasks.observations.own import trail
from irsim_gym.tasks.observations.scan import free_travel


def inverse(depth: float) -> float:
    return (1 / (depth + 0.5) - 0.3) / 1.7


def only(*observations: Any) -> dict[str, Any]:
    return {"name": "blank", "observations": list(observations)}


def wall(x: float, low: float, high: float) -> dict[str, Any]:
    return {"shape": {"name": "linestring", "vertices": [[x, low], [x, high]]}}


def seen(episodes: Episodes) -> Any:
    return episodes.view.observation[0, 0]


def observe(robot: dict[str, Any], obstacles: list[dict[str, Any]], name: str, **options: Any) -> Any:
    return seen(play(robot, obstacles, only({"name": name, **options})))


# --- free_travel


def test_way_ahead_of_a_wall_ends_where_the_disc_touches_it() -> None:
    ways = observe({"state": [5, 5, 0]}, [wall(7, 0, 10)], "free_travel", horizon=6, directions=4)
    # Directions: behind, right, ahead, left; 1.8 m ahead, nothing within 6 m behind.
    assert ways == pytest.approx([inverse(6.0), inverse(6.0), inverse(1.8), inverse(6.0)], abs=2e-3)


@pytest.mark.parametrize(("gap", "is_open"), [(0.36, False), (0.5, True)])
def test_a_gap_counts_only_if_the_agent_fits(gap: float, is_open: bool) -> None:
    walls = [wall(6, 0, 5 - gap / 2), wall(6, 5 + gap / 2, 10)]
    ahead = observe({"state": [5, 5, 0]}, walls, "free_travel", horizon=6, directions=2)[1]
    assert (ahead < inverse(3.0)) == is_open


def test_a_wall_alongside_does_not_shorten_the_way_but_with_a_margin_it_does() -> None:
    side = {"shape": {"name": "linestring", "vertices": [[0, 5.3], [10, 5.3]]}}
    assert observe({"state": [5, 5, 0]}, [side], "free_travel", horizon=6, directions=2)[1] == pytest.approx(
        inverse(6.0)
    )
    assert observe({"state": [5, 5, 0]}, [side], "free_travel", horizon=6, directions=2, margin=0.15)[1] > inverse(0.3)


def test_a_sensor_far_ahead_that_looks_back_sees_what_is_near_the_robot() -> None:
    sensor = {"name": "lidar2d", "number": 31, "angle_range": 0.1, "range_max": 8, "offset": [6, 0, np.pi]}
    robot = {"state": [2, 5, 0], "sensors": [sensor]}
    # A wall 0.05 m before the robot's disc of 0.2 m, 5.75 m from the sensor.
    ways = observe(robot, [wall(2.25, 4, 6)], "free_travel", horizon=0.1, directions=2)
    assert ways == pytest.approx([inverse(0.1), inverse(0.05)], abs=2e-3)


def test_the_mount_of_the_sensor_does_not_matter() -> None:
    sensor = {**ROBOT["sensors"][0], "number": 721, "offset": [0.1, 0.05, 1.0]}
    moved = observe({"state": [5, 5, 0.3], "sensors": [sensor]}, [wall(7, 0, 10)], "free_travel")
    centred = {**ROBOT["sensors"][0], "number": 721}
    plain = observe({"state": [5, 5, 0.3], "sensors": [centred]}, [wall(7, 0, 10)], "free_travel")
    near = plain > inverse(4.0)
    assert near.sum() >= 8
    assert moved[near] == pytest.approx(plain[near], abs=2e-2)


def test_ways_stay_within_their_bounds_and_agree_with_plain_python() -> None:
    episodes = play({"state": [5, 5, 0]}, [wall(5.201, 0, 10), wall(4.0, 0, 10)], only({"name": "free_travel"}))
    (_, low, high) = episodes.observation_terms[0]
    assert (seen(episodes) >= low).all()
    assert (seen(episodes) <= high).all()
    assert seen(episodes).max() == pytest.approx(high.max(), abs=0.01)
    directions = np.linspace(-np.pi, np.pi, 36, endpoint=False)
    tables = [np.cos(directions).astype(np.float32), np.sin(directions).astype(np.float32)]
    rows = [np.full(36, 6.0, np.float32) for _ in range(2)]
    for shorten, row in zip((free_travel.shorten, free_travel.shorten.py_func), rows, strict=True):
        for x, y in np.random.default_rng(0).uniform(-3, 3, (50, 2)).astype(np.float32):
            shorten(x, y, np.float32(0.04), np.float32(6.0), *tables, row)
    # Where a disc just touches a point, the last bit decides whether it blocks the way.
    assert np.isclose(rows[0], rows[1], atol=1e-4).sum() >= 35


def test_ways_agree_with_a_disc_that_is_pushed_along() -> None:
    generator = np.random.default_rng(3)
    points = generator.uniform(-4, 4, (30, 2)).astype(np.float32)
    angles = np.linspace(-np.pi, np.pi, 24, endpoint=False)
    row = np.full(24, 6.0, np.float32)
    for x, y in points:
        free_travel.shorten(
            x, y, np.float32(0.09), np.float32(6), np.cos(angles).astype("f4"), np.sin(angles).astype("f4"), row
        )
    steps = np.arange(0, 6, 0.002)
    for angle, way in zip(angles, row, strict=True):
        path = steps[:, None] * [np.cos(angle), np.sin(angle)]
        touching = (np.linalg.norm(path[:, None] - points, axis=2) < 0.3).any(axis=1)
        expected = steps[np.argmax(touching)] if touching.any() else 6.0
        assert way == pytest.approx(expected, abs=0.02)


def test_nothing_beyond_the_horizon_is_looked_at() -> None:
    near, far = (observe({"state": [5, 5, 0]}, [wall(x, 0, 10)], "free_travel", directions=2)[1] for x in (7.9, 8.3))
    assert near == pytest.approx(inverse(2.7), abs=2e-3)
    assert far == pytest.approx(inverse(3.0), abs=1e-6)


# --- goal_record


def test_record_tells_how_far_and_how_long_the_goal_was_nearer() -> None:
    robot = {"state": [2, 5, 0], "goal": [8, 5], "vel_min": [-1, -1.5]}
    episodes = play(robot, task=only({"name": "goal_record", "near": 1.0, "soon": 2.0}))
    assert seen(episodes).tolist() == [0, 0]
    for _ in range(5):
        drive(episodes, 1, 0)
        assert seen(episodes).tolist() == [0, 0]
    for _ in range(3):
        drive(episodes, -1, 0)
    assert seen(episodes) == pytest.approx([0.3 / 1.3, 0.3 / 2.3], abs=1e-6)
    episodes.begin_next(np.array([0]))
    assert seen(episodes).tolist() == [0, 0]


# --- trail


def test_trail_shows_the_nearest_mark_by_sector() -> None:
    options = {"name": "trail", "sectors": 4, "spacing": 0.19, "fresh": 1, "near": 0.5}
    episodes = play({"state": [2, 5, 0.1], "vel_min": [-1, -1.5]}, task=only(options))
    assert seen(episodes).tolist() == [0] * 4
    for _ in range(8):  # marks at 0, 0.2, 0.4, 0.6 and 0.8 m; the last is fresh
        drive(episodes, 1, 0)
    # Sectors: left behind, right behind ... in order of the bearing from -pi: the trail lies straight behind.
    behind = seen(episodes)
    assert sorted(behind)[:3] == [0, 0, 0]
    assert behind.max() == pytest.approx(0.5 / (0.2 + 0.5), abs=1e-6)
    assert int(np.argmax(behind)) in (0, 3)


def test_marks_are_left_by_way_not_by_time_and_old_ones_are_forgotten() -> None:
    marks, count = np.zeros((3, 2)), np.zeros(1, np.int64)
    for x in (0.0, 0.1, 0.25, 0.3, 0.5, 0.75):
        trail.leave_mark(x, 0.0, 0.25, marks, count, 0)
    assert count[0] == 4
    assert marks[:, 0].tolist() == [0.75, 0.25, 0.5]


def test_memory_is_each_worlds_own_and_copied_with_it() -> None:
    task = only({"name": "trail", "spacing": 0.05, "fresh": 0}, "goal_record")
    batch = play({"vel_min": [-1, -1.5]}, task=task, n_worlds=3)
    for action in ((1.0, 0.5), (0.5, -1.0), (-1.0, 0.3)) * 10:
        drive(batch, *action)
    twin = copy.deepcopy(batch)
    np.testing.assert_array_equal(batch.view.observation[0], batch.view.observation[2])
    batch.begin_next(np.array([1]))
    for episodes in (batch, twin):
        drive(episodes, 1.0, 0.0)
    np.testing.assert_array_equal(batch.view.observation[[0, 2]], twin.view.observation[[0, 2]])
    assert (batch.view.observation[1] != twin.view.observation[1]).any()
