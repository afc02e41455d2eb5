"""agents/studies/lost_starts.py: levels in which nothing that a robot does keeps it free of contact."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from irsim_gym.evaluation.requests.episode_setup import make_episodes

STUDIES = Path(__file__).parents[2] / "agents" / "studies"


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(STUDIES))
    import lost_starts

    return lost_starts


@pytest.mark.parametrize(("gap", "is_lost"), [(0.5, True), (3.0, False)])
def test_a_slow_robot_before_a_fast_disc(script: Any, gap: float, is_lost: bool) -> None:
    """The disc drives at it with 2 m/s: in 8 steps of 0.1 s it comes 1.6 m, and the robot yields 0.08 m at most."""
    robot = {
        "kinematics": {"name": "diff"},
        "vel_min": [0, -1],
        "vel_max": [0.1, 1],
        "state": [5, 5, 0],
        "goal": [9, 5, 0],
        "sensors": [{"name": "lidar2d", "number": 9}],
    }
    disc = {
        "kinematics": {"name": "omni"},
        "vel_max": [2, 2],
        "shape": {"name": "circle", "radius": 0.5},
        "state": [5.7 + gap, 5, 0],
        "goal": [1, 5, 0],
        "behavior": {"name": "dash"},
    }
    scenario = {"world": {"step_time": 0.1}, "robot": robot, "obstacle": disc}
    episodes = make_episodes(scenario, n_worlds=script.MANY)
    for count in (script.FEW, script.MANY):
        lasted = script.survived(episodes, 0, "dev", script.sequences(count))
        assert (lasted.max() == script.STEPS) is not is_lost
    assert script.can_survive(episodes, 0, "dev") is not is_lost
