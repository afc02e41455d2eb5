"""Every shipped scenario against the checkers and the tests that Gymnasium runs on its own environments."""

from __future__ import annotations

import json
import pickle
from copy import deepcopy

import gymnasium
import numpy as np
import pytest
from contract_tools import CHOSEN, FEATURES, SHIPPED, STILL, assert_same
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils import env_checker
from stable_baselines3.common import env_checker as sb3_env_checker

from irsim_gym.envs.gymnasium.single import WorldEnv

every = pytest.mark.parametrize("env_id", SHIPPED)
chosen = pytest.mark.parametrize("env_id", CHOSEN)


def test_scenarios_are_shipped():
    assert {STILL, "irsim_gym/cluttered_room-v0", "irsim_gym/dense_room-v0"} <= set(SHIPPED)
    assert len(CHOSEN) == len(FEATURES)


@every
def test_gymnasium_checker(env_id):
    env = gymnasium.make(env_id, render_mode="rgb_array")
    env_checker.check_env(env.unwrapped, skip_render_check=True)  # it opens windows: tests/gui does
    env_checker.env_render_passive_checker(env.unwrapped)
    env.close()


@chosen
def test_sb3_checker(env_id):
    sb3_env_checker.check_env(gymnasium.make(env_id).unwrapped, warn=True)


@pytest.mark.parametrize("task", [{"observation_form": "dict"}, {"action": {"name": "discrete"}}])
def test_checkers_with_other_spaces(task):
    env = gymnasium.make(STILL, task={"name": "navigation", **task}).unwrapped
    env_checker.check_env(env, skip_render_check=True)
    sb3_env_checker.check_env(env, warn=True)


@chosen
def test_rollout_is_deterministic(env_id):
    one, two = (gymnasium.make(env_id, max_steps=40) for _ in range(2))
    assert_same(one.reset(seed=0), two.reset(seed=0))
    one.action_space.seed(0)
    for _ in range(60):
        action = one.action_space.sample()
        here, there = one.step(action), two.step(action)
        assert here[0] in one.observation_space
        assert_same(here, there)
        if here[2] or here[3]:
            assert_same(one.reset(), two.reset())


@chosen
def test_pickled_environment_goes_on_alike(env_id):
    env = gymnasium.make(env_id, max_steps=30)
    env.reset(seed=3)
    actions = [env.action_space.sample() for _ in range(40)]
    for action in actions[:5]:
        env.step(action)
    twins = [pickle.loads(pickle.dumps(env)), deepcopy(env)]
    for action in actions[5:]:
        here = env.step(action)
        for twin in twins:
            assert_same(twin.step(action), here)
        if here[2] or here[3]:
            here = env.reset()
            for twin in twins:
                assert_same(twin.reset(), here)


@chosen
def test_rendering(env_id):
    env = gymnasium.make(env_id, render_mode="rgb_array")
    env.reset(seed=1)
    first = env.render()
    assert (first.dtype, first.ndim, first.shape[2]) == (np.uint8, 3, 3)
    kept = first.copy()
    for _ in range(8):
        env.step(np.array([1.0, 0.2], np.float32))
    second = env.render()
    assert not np.shares_memory(first, second)
    np.testing.assert_array_equal(first, kept)
    assert (first != second).any()
    env.close()
    env.close()


def test_other_render_modes_are_refused():
    with pytest.raises(ValueError, match="render_mode"):
        WorldEnv("sparse_circles", render_mode="nothing")


def test_rendering_without_a_mode_warns():
    env = gymnasium.make(STILL).unwrapped
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="render_mode"):
        assert env.render() is None


@chosen
def test_spec_round_trips(env_id):
    env = gymnasium.make(env_id, max_steps=7)
    spec = env.spec
    assert spec is not None
    assert spec.max_episode_steps == 7
    again = EnvSpec.from_json(spec.to_json())
    json.loads(spec.to_json())
    assert again == spec
    assert again.make().spec == spec
    assert gymnasium.make(spec).spec == spec


def test_vector_spec_round_trips():
    envs = gymnasium.make_vec(STILL, num_envs=3, autoreset_mode="SameStep", max_steps=9)
    spec = envs.spec
    assert spec is not None
    again = gymnasium.make_vec(EnvSpec.from_json(spec.to_json()))
    assert again.spec == spec
    assert (again.num_envs, again.metadata["autoreset_mode"].value) == (3, "SameStep")
    seen, others = envs.reset(seed=4), gymnasium.make_vec(spec).reset(seed=4)
    assert_same(seen, others)
