"""Acceleration and jerk of driven episodes, against hand calculations."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.evaluation.measures.metrics import EpisodeRow
from irsim_gym.evaluation.protocol.protocol import evaluate

TASK = {"name": "blank", "max_steps": 20, "observations": ["goal"], "rewards": ["progress"], "endings": ["collided"]}


def driven(robot: dict[str, Any], action: list[float], *, max_steps: int = 20) -> EpisodeRow:
    robot = {"kinematics": {"name": "diff"}, "vel_min": [-1, -1], "vel_max": [1, 1], "goal": [90, 5]} | robot
    wall = {"shape": {"name": "circle", "radius": 1}, "state": [50, 50]}
    world = {"width": 100, "height": 100, "step_time": 0.1}
    scenario = {"world": world, "robot": robot, "obstacle": wall, "task": TASK | {"max_steps": max_steps}}
    constant = np.array(action, np.float32)
    (row,) = evaluate(lambda seen: np.tile(constant, (len(seen), 1)), Worlds(scenario, 1).episodes, 1)
    return row


def test_speeding_up_and_cruising() -> None:
    """1 m/s2 for ten steps, then none for ten: the only jerk is the end of the acceleration, 10 m/s3 in one of 19."""
    row = driven({"state": [5, 5, 0], "acce": [1.0, 1.0]}, [1.0, 0.0])
    assert (row.acceleration, row.jerk) == (pytest.approx(0.5), pytest.approx(10.0 / 19))


def test_a_turn_at_full_speed_accelerates_towards_its_centre() -> None:
    """A velocity of constant size that turns by 0.1 rad a step changes by the chord, 2 sin(0.05) m/s."""
    chord = 2.0 * math.sin(0.05) / 0.1
    row = driven({"state": [5, 5, 0], "velocity": [1.0, 1.0]}, [1.0, 1.0], max_steps=200)
    assert row.acceleration == pytest.approx(chord, rel=0.01)
    assert row.jerk == pytest.approx(chord * chord, rel=0.01)


def test_turning_on_the_spot_is_smooth() -> None:
    row = driven({"state": [5, 5, 0], "velocity": [0.0, 1.0]}, [0.0, 1.0])
    assert (row.acceleration, row.jerk) == (0.0, 0.0)


def test_the_stop_by_a_collision_does_not_count() -> None:
    """0.35 m of room at 0.1 m a step: three steps without any change, and the fourth collides."""
    row = driven({"state": [48.45, 50, 0], "velocity": [1.0, 0.0]}, [1.0, 0.0])
    assert (row.outcome, row.steps) == ("collision", 4)
    assert (row.acceleration, row.jerk) == (0.0, 0.0)


def test_success_by_completion_time_compares_with_the_fastest_drive() -> None:
    """3.7 m to the goal's tolerance at 1 m/s take 37 steps; with 1 m/s2 from rest ten steps make 0.55 m, 31.5 more."""
    towards = {
        "name": "blank",
        "max_steps": 90,
        "observations": ["goal"],
        "rewards": ["arrival"],
        "endings": ["arrived"],
    }
    for given, steps in (({}, 37), ({"acce": [1.0, 1.0]}, 42)):
        robot = {"kinematics": {"name": "diff"}, "vel_min": [-1, -1], "vel_max": [1, 1], "goal_threshold": 0.3} | given
        scenario = {"robot": robot | {"state": [2, 5, 0], "goal": [6, 5]}, "task": towards}
        for speed, factor in ((1.0, 1.0), (0.5, 0.5)):
            action = np.array([speed, 0.0], np.float32)
            drive = lambda seen, action=action: np.tile(action, (len(seen), 1))  # noqa: E731
            (row,) = evaluate(drive, Worlds(scenario, 1).episodes, 1)
            assert (row.outcome, row.least_time) == ("success", pytest.approx(0.1 * steps))
            assert row.sct == pytest.approx(row.least_time / row.time) == pytest.approx(factor, abs=0.13)
    assert replace(row, outcome="timeout").sct == 0.0
