"""Keywords that other libraries have for making environments, and names that are nearly ours."""

from __future__ import annotations

import numpy as np
import pytest
from contract_tools import STILL
from sb3_contrib.common.wrappers import TimeFeatureWrapper
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv

import irsim_gym
from irsim_gym.errors import IrsimGymError, UnknownNameError

TEAM = "corridor_two_way"


@pytest.mark.parametrize("given", [{"wrappers": [TimeFeatureWrapper]}, {"vector_kwargs": {"copy": False}}])
def test_what_gymnasium_does_with_single_environments_alone(given):
    with pytest.raises(IrsimGymError, match=f"{next(iter(given))} is for .* vectorization_mode='sync' or 'async'"):
        irsim_gym.make_vec(STILL, 2, **given)
    assert irsim_gym.make_vec(STILL, 2, vectorization_mode="sync", **given).num_envs == 2


@pytest.mark.parametrize("cls", [DummyVecEnv, pytest.param(SubprocVecEnv, marks=pytest.mark.slow)])
def test_stable_baselines3_makes_ours(cls):
    kwargs = {"wrapper_class": TimeFeatureWrapper, "vec_env_cls": cls, "env_kwargs": {"max_episode_steps": 8}}
    env = make_vec_env(f"irsim_gym:{STILL}", n_envs=2, seed=0, **kwargs)  # workers import the package by the id
    left = [env.reset()[:, -1], *(env.step(np.zeros((2, 2), np.float32))[0][:, -1] for _ in range(3))]
    np.testing.assert_allclose(left, np.repeat([[1.0], [7 / 8], [6 / 8], [5 / 8]], 2, axis=1))
    env.close()


MAKERS = {
    "make": lambda **given: irsim_gym.make(STILL, **given),
    "make_vec": lambda **given: irsim_gym.make_vec(STILL, 2, **given),
    "sb3.make_vec_env": lambda **given: irsim_gym.sb3.make_vec_env(STILL, 2, **given),
    "parallel_env": lambda **given: irsim_gym.parallel_env(TEAM, **given),
    "make_batch": lambda **given: irsim_gym.make_batch(TEAM, 2, **given),
    "sb3.make_multi_agent_vec_env": lambda **given: irsim_gym.sb3.make_multi_agent_vec_env(TEAM, 2, **given),
}


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("max_step", "did you mean 'max_steps'?"),
        ("tsk", "did you mean 'task'?"),
        ("rendermode", "did you mean 'render_mode'?"),
        ("num_thread", "did you mean 'num_threads', an argument of make_vec, make_batch and those of sb3?"),
        ("num_worlds", "the number of worlds is 'num_envs' of make_vec, make_batch and sb3.make_multi_agent_vec_env"),
        ("horizon", "the time limit is 'max_steps'"),
        ("kwargs", "pass its contents as keywords of this function"),
        ("env_config", "pass its contents as keywords of this function"),
        ("num_workers", "use 'num_threads'"),
    ],
)
def test_a_keyword_of_nobody_leads_to_one_that_exists(name, told):
    for make in MAKERS.values():
        with pytest.raises(UnknownNameError) as found:
            make(**{name: 3})
        assert told in str(found.value)


@pytest.mark.parametrize(
    ("name", "owners", "told"),
    [
        ("env_kwargs", (), "Stable-Baselines3's own make_vec_env; pass its contents as keywords"),
        ("monitor_dir", (), "own make_vec_env; Stable-Baselines3's VecMonitor(env, FILE) writes one file"),
        ("vec_env_cls", (), "Stable-Baselines3's own make_vec_env; use 'num_threads'"),
        ("wrapper_class", (), "Stable-Baselines3's own make_vec_env; wrap the returned environment"),
        ("vector_kwargs", ("make_vec",), "an argument of make_vec with vectorization_mode='sync'"),
        ("max_cycles", ("parallel_env",), "an argument of parallel_env; the time limit is 'max_steps'"),
        ("autoreset_mode", ("make_vec",), "an argument of make_vec"),
    ],
)
def test_a_keyword_of_another_function_is_told_with_its_owner(name, owners, told):
    for maker, make in MAKERS.items():
        if maker not in owners:
            with pytest.raises(UnknownNameError) as found:
                make(**{name: {}})
            assert told in str(found.value)
