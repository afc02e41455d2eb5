"""The native batch equals Gymnasium's ``SyncVectorEnv`` of single environments, bit for bit."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from contract_tools import MOVING, STILL, assert_same, forward_actions
from gymnasium.vector import AutoresetMode, SyncVectorEnv

N = 6


def pair(env_id, mode, n=N, **kwargs):
    """The native batch and the built-in one."""
    native = gymnasium.make_vec(env_id, num_envs=n, autoreset_mode=mode, **kwargs)
    sync = gymnasium.make_vec(
        env_id, num_envs=n, vectorization_mode="sync", vector_kwargs={"autoreset_mode": mode}, **kwargs
    )
    assert isinstance(sync, SyncVectorEnv)
    assert native.observation_space == sync.observation_space
    assert native.action_space == sync.action_space
    assert native.single_observation_space == sync.single_observation_space
    assert native.metadata["autoreset_mode"] is sync.metadata["autoreset_mode"]
    return native, sync


def roll(native, sync, n_steps, seed=5, actions=forward_actions):
    """Step both alike; return how many episodes ended."""
    rng = np.random.default_rng(seed)
    assert_same(native.reset(seed=seed), sync.reset(seed=seed))
    ends = 0
    for _ in range(n_steps):
        chosen = actions(rng, native.action_space.shape)
        here, there = native.step(chosen), sync.step(chosen)
        assert_same(here, there)
        ended = here[2] | here[3]
        ends += int(ended.sum())
        if native.metadata["autoreset_mode"] is AutoresetMode.DISABLED and ended.any():
            reset = [env.reset(options={"reset_mask": ended.copy()}) for env in (native, sync)]
            assert_same(*reset)
    return ends


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("env_id", [STILL, MOVING, "irsim_gym/cluttered_room-v0"])
def test_native_equals_sync(env_id, mode):
    native, sync = pair(env_id, mode, max_steps=45)
    assert roll(native, sync, 1000) > 50


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("n", [1, 3])
def test_dict_observations_and_small_batches(mode, n):
    native, sync = pair(STILL, mode, n, max_steps=20, task={"name": "navigation", "observation_form": "dict"})
    assert roll(native, sync, 120) >= n * 4


def test_discrete_actions():
    native, sync = pair(STILL, "SameStep", max_steps=25, task={"name": "navigation", "action": {"name": "discrete"}})
    n_choices = native.single_action_space.n
    assert roll(native, sync, 150, actions=lambda rng, shape: rng.integers(n_choices, size=shape)) > 10


def test_list_seeds_and_going_on_without_seed():
    native, sync = pair(STILL, "NextStep", max_steps=15)
    seeds = [7, 7, 100, 3, None, 2**40]
    first = [env.reset(seed=[0, 1, 2, 3, 4, 5]) for env in (native, sync)]
    assert_same(*first)
    assert_same(native.reset(seed=seeds), sync.reset(seed=seeds))
    assert native.np_random_seed == sync.np_random_seed
    assert [g.random() for g in native.np_random] == [g.random() for g in sync.np_random]
    assert_same(native.reset(), sync.reset())


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_reset_mask_clears_a_pending_restart(mode):
    native, sync = pair(STILL, mode, max_steps=4)
    both = (native, sync)
    assert_same(*[env.reset(seed=1) for env in both])
    actions = np.zeros((N, 2), np.float32)
    for _ in range(4):
        steps = [env.step(actions) for env in both]
        assert_same(*steps)
    mask = np.ones(N, np.bool_) if mode is AutoresetMode.DISABLED else np.arange(N) % 2 == 0
    assert_same(*[env.reset(options={"reset_mask": mask.copy()}) for env in both])
    for _ in range(3):
        assert_same(*[env.step(actions) for env in both])


def test_world_of_a_batch_equals_a_single_environment():
    n, w = 5, 3
    envs = gymnasium.make_vec(MOVING, num_envs=n, max_steps=40)
    env = gymnasium.make(MOVING, max_steps=40)
    observations, _ = envs.reset(seed=10)
    observation, _ = env.reset(seed=10 + w)
    np.testing.assert_array_equal(observations[w], observation)
    rng, again = np.random.default_rng(0), False
    for _ in range(200):
        actions = forward_actions(rng, (n, 2))
        observations, rewards, terminations, truncations, infos = envs.step(actions)
        if again:
            observation, info = env.reset()
            reward, terminated, truncated = 0.0, False, False
        else:
            observation, reward, terminated, truncated, info = env.step(actions[w])
        np.testing.assert_array_equal(observations[w], observation)
        assert (rewards[w], terminations[w], truncations[w]) == (reward, terminated, truncated)
        assert infos["level"][w] == info["level"]
        again = terminated or truncated
