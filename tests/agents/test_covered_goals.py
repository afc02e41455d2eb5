"""agents/studies/covered_goals.py: levels that no robot could have won while bodies moved as they did."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

STUDIES = Path(__file__).parents[2] / "agents" / "studies"


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(STUDIES))
    import covered_goals

    return covered_goals


def room(speed: float = 1.0, walls: Any = (), obstacle: Any = None) -> dict[str, Any]:
    """Return a world of 4 x 4 m in which the robot is to drive 2.4 m to the right within 4 s."""
    robot = {
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.2},
        "vel_min": [-speed, 0],
        "vel_max": [speed, 0],
        "state": [0.8, 2, 0],
        "goal": [3.2, 2, 0],
        "goal_threshold": 0.1,
    }
    lines = [{"shape": {"name": "linestring", "vertices": vertices}} for vertices in walls]
    task = {"name": "blank", "max_steps": 40, "observations": ["goal"], "endings": ["arrived", "collided"]}
    obstacles = [*lines, *([obstacle] if obstacle else [])]
    return {
        "world": {"height": 4, "width": 4, "step_time": 0.1},
        "robot": robot,
        "task": task,
        **({"obstacle": obstacles} if obstacles else {}),
    }


def disc(x: float, y: float, goal_y: float, speed: float) -> dict[str, Any]:
    """Return a disc of 0.3 m that drives up or down."""
    return {
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.3},
        "vel_min": [-speed, -speed],
        "vel_max": [speed, speed],
        "state": [x, y, 0],
        "goal": [x, goal_y, 0],
        "behavior": {"name": "dash"},
    }


ACROSS = [[[2, -1], [2, 5]]]
GAP = [[[2, -1], [2, 1.7]], [[2, 2.3], [2, 5]]]
NARROW = [[[2, -1], [2, 1.85]], [[2, 2.15], [2, 5]]]
AROUND = [[[2, 1], [2, 3]]]


@pytest.mark.parametrize(
    ("scenario", "is_winnable"),
    [
        (room(), True),
        (room(speed=0.3), False),  # 1.2 m in 4 s
        (room(walls=GAP), True),
        (room(walls=ACROSS), False),
        (room(walls=NARROW), False),  # 0.3 m wide
        (room(speed=2.0, walls=AROUND), True),
        (room(obstacle=disc(3.2, 2.0, 3.4, 0.02)), False),  # the goal stays covered
        (room(obstacle=disc(3.2, 2.0, 3.4, 0.5)), True),  # it is free after a second
        (room(obstacle=disc(3.2, 3.0, 2.0, 0.6)), False),  # it is free for a second only, and the way takes 2.3 s
    ],
)
def test_a_level_can_be_won_if_places_lead_to_the_goal(script: Any, scenario: Any, is_winnable: bool) -> None:
    assert script.winnable(scenario, "orca", np.arange(1), "dev") == [is_winnable]
