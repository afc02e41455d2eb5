"""SBX: Stable-Baselines3 in JAX."""

from __future__ import annotations

import numpy as np
import pytest
from needed import library

import irsim_gym


@pytest.fixture(scope="module")
def sbx():
    return library("sbx")


@pytest.mark.parametrize("name", ["PPO", "SAC"])
def test_it_trains(sbx, name):
    env = irsim_gym.sb3.make_vec_env("empty_goal", 4, seed=0, max_steps=20)
    given = {"n_steps": 16, "batch_size": 32} if name == "PPO" else {"learning_starts": 32, "batch_size": 32}
    model = getattr(sbx, name)("MlpPolicy", env, seed=0, **given)
    observations = env.reset()
    before = model.predict(observations, deterministic=True)[0]
    model.learn(128)
    after = model.predict(observations, deterministic=True)[0]
    assert after.shape == (4, 2)
    assert np.isfinite(after).all()
    assert (before != after).any()
    assert all(info["l"] == 20 for info in model.ep_info_buffer)
