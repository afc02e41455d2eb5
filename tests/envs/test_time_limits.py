"""Time limits as Gymnasium knows them: ``max_episode_steps`` in specs, ``TimeLimit``, and what infos tell."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.wrappers import FrameStackObservation, TimeAwareObservation, TimeLimit
from sb3_contrib.common.wrappers import TimeFeatureWrapper

import irsim_gym
from irsim_gym.envs.gymnasium.registration import env_id
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs.library import scenario_names
from irsim_gym.tasks import Outcome, load_task

ONE = "limits/waits-v0"
FILE = """
robot: {kinematics: {name: diff}, state: [1, 1, 0], goal: [5, 5, 0]}
task: {name: blank, max_steps: 6, observations: [goal], rewards: [{name: time, weight: 12.0}]}
"""


@pytest.fixture(autouse=True, scope="module")
def registered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("worlds")
    (folder / "waits.yaml").write_text(FILE)
    (folder / "broken.yaml").write_text("robot: {kinematics: {name: wheels}}")
    before = dict(gymnasium.registry)
    irsim_gym.register_scenarios(folder, namespace="limits")
    yield
    gymnasium.registry.clear()
    gymnasium.registry.update(before)


def test_ids_tell_the_limits_of_their_tasks():
    for name in scenario_names():
        limit = load_task(load_scenario(name)).max_steps
        assert (name, gymnasium.spec(env_id(name)).max_episode_steps) == (name, limit)
    assert gymnasium.spec(ONE).max_episode_steps == 6
    assert gymnasium.spec("irsim_gym/World-v0").max_episode_steps is None
    assert gymnasium.spec("limits/broken-v0").max_episode_steps is None


def first_end(env: Any) -> tuple[int, Outcome, float]:
    """Return the step in which an episode of waiting is cut, what is told, and what the step was paid."""
    env.reset(seed=0)
    for step in range(1, 20):
        _, reward, terminated, truncated, info = env.step(np.zeros(env.action_space.shape, np.float32))
        assert not np.any(terminated)
        if np.any(truncated):
            assert np.all(truncated)
            return step, Outcome(np.ravel(info["outcome"])[0]), float(np.ravel(reward)[0])
        assert np.all(np.asarray(info["outcome"]) == Outcome.RUNNING)
    raise AssertionError("no end")


@pytest.mark.parametrize(
    ("kwargs", "limit"),
    [
        ({}, 6),
        ({"max_episode_steps": 4}, 4),
        ({"max_episode_steps": 12}, 12),
        ({"max_episode_steps": -1}, 6),
        ({"max_steps": 12}, 12),
        ({"max_steps": 12, "max_episode_steps": 3}, 3),
        ({"max_steps": 3, "max_episode_steps": 12}, 3),
        ({"task": {"name": "blank", "max_steps": 8, "observations": ["goal"], "rewards": ["time"]}}, 8),
    ],
)
def test_specs_ends_and_costs_agree(kwargs, limit):
    weight = 12.0 if "task" not in kwargs else 2.0  # a step costs weight / limit
    for mode in (None, "sync", "vector_entry_point"):
        if mode is None:
            env = gymnasium.make(ONE, **kwargs)
            assert TimeAwareObservation(env).max_timesteps == TimeFeatureWrapper(env)._max_steps == limit
        else:
            env = gymnasium.make_vec(ONE, num_envs=2, vectorization_mode=mode, **kwargs)
            assert [spec.max_episode_steps for spec in env.get_attr("spec")] == [limit] * 2
        assert env.spec.max_episode_steps == limit
        step, outcome, paid = first_end(env)
        assert (step, outcome) == (limit, Outcome.TIMEOUT)
        assert paid == pytest.approx(-weight / limit)
        assert env.spec.max_episode_steps == limit
    native = irsim_gym.sb3.make_vec_env(ONE, 2, seed=0, **kwargs)
    assert [spec.max_episode_steps for spec in native.get_attr("spec")] == [limit] * 2
    native.reset()
    steps = [native.step(np.zeros((2, 2), np.float32)) for _ in range(limit)]
    assert [bool(step[2].any()) for step in steps] == [False] * (limit - 1) + [True]
    assert [info["TimeLimit.truncated"] for info in steps[-1][3]] == [True] * 2
    assert [info["outcome"] for info in steps[-1][3]] == [Outcome.TIMEOUT] * 2


def test_a_limit_set_later_counts_from_the_next_reset_on():
    env = gymnasium.make(ONE, max_episode_steps=5)
    assert first_end(env)[:2] == (5, Outcome.TIMEOUT)
    env.set_wrapper_attr("_max_episode_steps", 9)
    assert first_end(env)[:2] == (9, Outcome.TIMEOUT)
    env.set_wrapper_attr("max_steps", 3)
    assert first_end(env)[:2] == (3, Outcome.TIMEOUT)
    env.unwrapped.max_steps = 20
    assert (env.unwrapped.max_steps, first_end(env)[:2]) == (9, (9, Outcome.TIMEOUT))
    env.unwrapped.worlds.limit(15)
    assert first_end(env)[:2] == (9, Outcome.TIMEOUT)
    assert first_end(gymnasium.make(ONE, max_episode_steps=5).unwrapped)[:2] == (6, Outcome.TIMEOUT)
    inner = env.unwrapped
    inner.max_steps = 7
    assert first_end(inner)[:2] == (7, Outcome.TIMEOUT)
    with pytest.raises(ValueError, match="max_steps must be a whole number >= 1, got 0"):
        inner.max_steps = 0


class Twice(gymnasium.Wrapper):
    """Each step is two of the environment's."""

    def step(self, action):
        self.env.step(action)
        return self.env.step(action)


def test_a_time_limit_around_anything():
    """It is the environment's own where it counts the same steps."""
    for wrapped in (
        irsim_gym.make(ONE),
        FrameStackObservation(irsim_gym.make(ONE), 2),
        TimeLimit(irsim_gym.make(ONE), 9),
    ):
        assert first_end(TimeLimit(wrapped, 4))[:2] == (4, Outcome.TIMEOUT)
    assert TimeLimit(irsim_gym.make(ONE, max_steps=3), 4).spec.max_episode_steps == 3
    assert first_end(TimeLimit(Twice(irsim_gym.make(ONE)), 5))[:2] == (3, Outcome.TIMEOUT)
    assert first_end(TimeLimit(Twice(irsim_gym.make(ONE)), 2))[:2] == (2, Outcome.RUNNING)


def test_specs_make_the_same_again():
    spec = gymnasium.make(ONE, max_episode_steps=9).spec
    stored = EnvSpec.from_json(spec.to_json())
    assert type(stored) is EnvSpec
    assert spec == stored
    assert spec == gymnasium.make(stored).spec == gymnasium.make(spec).spec
    assert (spec != gymnasium.make(ONE).spec, gymnasium.make(ONE).spec.max_episode_steps) == (True, 6)
    assert gymnasium.make(gymnasium.make(ONE).spec, max_steps=12).spec.max_episode_steps == 12
    assert first_end(gymnasium.make_vec(stored, num_envs=2))[:2] == (9, Outcome.TIMEOUT)
    assert gymnasium.make_vec(spec, num_envs=2, max_steps=7).spec.max_episode_steps == 7
    data = {"robot": {"kinematics": {"name": "diff"}, "state": [1, 1, 0], "goal": [5, 5, 0]}, "task": {"max_steps": 11}}
    assert irsim_gym.make(data).spec.max_episode_steps == irsim_gym.make_vec(data, 2).spec.max_episode_steps == 11
    assert repr(gymnasium.spec(ONE)).count("max_episode_steps=6") == 1
    with pytest.raises(ValueError, match=r"max_episode_steps must be a whole number >= 1, or -1 .*, got 0"):
        gymnasium.make_vec(ONE, num_envs=2, max_episode_steps=0)
