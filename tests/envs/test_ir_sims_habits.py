"""IR-SIM's habits with an environment: each error says where a world by hand is."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from irsim.env import EnvBase

import irsim_gym
from irsim_gym.envs.parts.by_hand import OF_WORLDS
from irsim_gym.errors import UnknownKeywordError

LOAD = r"run a world by hand, as in IR-SIM, use irsim_gym\.load\('my_world\.yaml'\), or irsim\.make"


@pytest.mark.parametrize(
    ("call", "error", "said"),
    [
        (lambda env: env.step(), TypeError, "step() takes one action"),
        (lambda env: env.step([0.5, 0.1], 0), TypeError, "step() takes one action"),
        (lambda env: env.step([0.5, 0.1], action_id=0), TypeError, "step() takes one action"),
        (lambda env: env.render(0.05), TypeError, "render() takes no arguments"),
        (lambda env: env.render(mode="all"), TypeError, "render() takes no arguments"),
        (lambda env: env.done(), AttributeError, "no attribute 'done'"),
        (lambda env: env.end(ani_name="run"), AttributeError, "no attribute 'end'"),
        (lambda env: env.get_lidar_scan(), AttributeError, "no attribute 'get_lidar_scan'"),
        (lambda env: env.robot.state, AttributeError, "no attribute 'robot'"),
    ],
)
def test_habits_are_answered(call: Callable[[Any], Any], error: type[Exception], said: str) -> None:
    env = irsim_gym.make("empty_goal")
    env.reset(seed=0)
    with pytest.raises(error, match=LOAD) as told:
        call(env)
    assert said in str(told.value)


@pytest.mark.parametrize(
    "habit",
    [{"display": False}, {"save_ani": True}, {"headless": True}, {"log_level": "INFO"}, {"world_name": "a.yaml"}],
)
def test_arguments_of_load_are_told_as_such(habit: dict[str, Any]) -> None:
    (name,) = habit
    with pytest.raises(
        UnknownKeywordError, match=f"'{name}' .an argument of load, which runs a file by hand as IR-SIM"
    ):
        irsim_gym.make("empty_goal", **habit)


def test_the_names_are_those_that_a_world_by_hand_has_of_ir_sims() -> None:
    world, env = irsim_gym.load("empty_goal"), irsim_gym.make("empty_goal")
    assert all(hasattr(world, name) and not hasattr(env, name) for name in OF_WORLDS)
    names = {name for name in dir(EnvBase) if not name.startswith("_") and hasattr(world, name)}
    assert names - {"close", "render", "reset", "step"} <= OF_WORLDS


def test_the_environment_is_otherwise_as_gymnasium_makes_it() -> None:
    """Spec, pickle and wrappers around it know nothing of the layer that answers; its steps are the same."""
    env, plain = irsim_gym.make("empty_goal"), gymnasium.make("irsim_gym/empty_goal-v0")
    assert env.spec == plain.spec
    assert gymnasium.wrappers.ClipAction(env).spec == gymnasium.wrappers.ClipAction(plain).spec
    assert env.get_wrapper_attr("worlds") is env.unwrapped.worlds  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match=r"'worlds' \(env\.unwrapped\.worlds exists\)$"):
        env.worlds  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match=r"'nothing'$"):
        env.nothing  # type: ignore[attr-defined]  # noqa: B018
    copied = pickle.loads(pickle.dumps(env))
    begun = [one.reset(seed=3)[0] for one in (env, plain, copied)]
    stepped = [one.step(np.array([1.0, 0.5], np.float32)) for one in (env, plain, copied)]
    for seen, step in zip(begun[1:], stepped[1:], strict=True):
        np.testing.assert_array_equal(seen, begun[0])
        np.testing.assert_array_equal(step[0], stepped[0][0])
        assert step[1:] == stepped[0][1:]
