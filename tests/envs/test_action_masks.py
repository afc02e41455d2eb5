"""``action_masks``: which choices of a discrete action are worth trying."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym
from irsim_gym.envs.gymnasium.single import WorldEnv
from irsim_gym.envs.gymnasium.vector import WorldVectorEnv
from irsim_gym.envs.sb3.vec_env import make_vec_env
from irsim_gym.errors import IrsimGymError

TASK = {"action": {"name": "discrete", "linear": 2, "angular": 3}}


def world(vel_min: list[float], vel_max: list[float], n_robots: int = 1) -> dict[str, Any]:
    robots = [
        {"kinematics": {"name": "diff"}, "state": [2, 2 + 3 * k, 0], "goal": [8, 2 + 3 * k], "vel_min": vel_min,
         "vel_max": vel_max} for k in range(n_robots)
    ]  # fmt: skip
    return {"world": {"width": 10, "height": 10}, "robot": robots}


@pytest.mark.parametrize(
    ("vel_min", "vel_max", "expected"),
    [
        ([-1, -1], [1, 1], [1, 1, 1, 1, 1, 1]),
        ([0.5, -1], [0.5, 1], [1, 1, 1, 0, 0, 0]),  # one speed alone: slow and fast are the same
        ([0, 0], [1, 0], [1, 0, 0, 1, 0, 0]),  # it cannot turn
    ],
)
def test_choices_that_command_the_same(vel_min: list[float], vel_max: list[float], expected: list[int]) -> None:
    scenario = world(vel_min, vel_max)
    mask = WorldEnv(scenario, TASK).action_masks()
    assert mask.dtype == np.bool_
    assert mask.tolist() == [bool(value) for value in expected]
    assert WorldVectorEnv(scenario, 3, TASK).action_masks().tolist() == [mask.tolist()] * 3
    slots = make_vec_env(scenario, 2, 0, task=TASK)
    assert np.stack(slots.env_method("action_masks")).tolist() == [mask.tolist()] * 2  # as sb3-contrib asks
    mask[:] = False
    assert slots.env_method("action_masks")[0].any()
    team = irsim_gym.parallel_env(world(vel_min, vel_max, 2), task=TASK)
    _, infos = team.reset(seed=0)
    assert [info["action_mask"].tolist() for info in infos.values()] == [expected, expected]
    for name in team.agents:
        team.action_space(name).seed(0)
        assert expected[team.action_space(name).sample(infos[name]["action_mask"])] == 1


def test_continuous_actions_have_no_mask() -> None:
    scenario = world([-1, -1], [1, 1])
    with pytest.raises(IrsimGymError, match="action_masks is for tasks with choices"):
        WorldEnv(scenario).action_masks()
    _, infos = irsim_gym.parallel_env(scenario).reset(seed=0)
    assert "action_mask" not in infos["robot_0"]
