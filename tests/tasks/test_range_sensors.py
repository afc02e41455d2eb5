"""Observations of noisy scans, short ranges and several sensors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import ROBOT, play

from irsim_gym.errors import ScenarioError

ONLY_SCAN = [{"name": "scan", "code": "linear"}]
BALL: dict[str, Any] = {"shape": {"name": "circle", "radius": 0.5}, "state": [4.2, 5, 0]}
AHEAD: dict[str, Any] = {"name": "lidar2d", "number": 1, "range_max": 4}


def observe(*sensors: dict[str, Any], observations: Any = ONLY_SCAN, n_worlds: int = 1) -> Any:
    task = {"name": "blank", "observations": observations}
    return play({"sensors": list(sensors)}, BALL, task, n_worlds)


def test_the_first_range_sensor_of_the_file_is_observed() -> None:
    # The ball begins 1.7 m ahead of the sensor, 1.5 m beyond the robot's own outline.
    behind = {**AHEAD, "offset": [0, 0, "pi"], "noise": False}
    other_beams = {"name": "lidar2d", "number": 5, "angle_range": "pi / 8", "range_max": 4}
    assert observe(AHEAD, behind).view.observation[0, 0] == pytest.approx([1 - 1.5 / 4], abs=1e-6)
    assert observe(behind, AHEAD).view.observation[0, 0] == pytest.approx([1 - 3.8 / 4], abs=1e-6)
    assert observe(other_beams, AHEAD).view.observation.shape[2] == 5


def test_what_is_too_near_reads_as_near() -> None:
    short = {**AHEAD, "range_min": 1.9}
    assert observe(short).view.observation[0, 0] == pytest.approx([1 - 1.7 / 4], abs=1e-6)


@pytest.mark.parametrize("name", ["lidar2d", "fmcw_lidar2d"])
def test_noisy_scans_stay_within_the_bounds(name: str) -> None:
    sensor = {"name": name, "number": 60, "angle_range": "2 * pi", "range_max": 3, "noise": True, "std": 3}
    episodes = observe(sensor, observations=["scan", "free_travel"], n_worlds=20)
    for _ in range(3):
        episodes.step(np.zeros((20, 1, 2)))
        column = 0
        for _, low, high in episodes.observation_terms:
            values = episodes.view.observation[:, 0, column : column + len(low)]
            assert ((values >= low) & (values <= high)).all()
            column += len(low)
    assert np.ptp(episodes.view.observation[:, 0], axis=0).max() > 0.1


def test_learners_must_share_their_kind_of_sensor() -> None:
    robots = [{**ROBOT, "state": [2, y, 0], "sensors": [{**AHEAD, "noise": y > 4}]} for y in (2, 5)]
    with pytest.raises(ScenarioError, match="sensors of one kind with the same beams, all noisy or none"):
        play(robots, BALL, {"agents": "all", "observations": ONLY_SCAN}, team=True)


def test_sensors_that_differ_are_told_once() -> None:
    robots = [{**ROBOT, "state": [2, y, 0], "sensors": [{**AHEAD, "number": y}]} for y in (2, 5, 8)]
    with pytest.raises(ScenarioError) as caught:
        play(robots, BALL, {"name": "blank", "agents": "all", "observations": ONLY_SCAN}, team=True)
    (problem,) = caught.value.problems
    assert "robot_0 has {name: lidar2d, number: 2" in problem.message
    assert "robot_1 has {name: lidar2d, number: 5" in problem.message
