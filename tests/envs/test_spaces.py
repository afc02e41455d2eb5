"""Spaces and the forms of observations."""

from __future__ import annotations

import numpy as np
from gymnasium.spaces import Box, Dict, Discrete

from irsim_gym.envs.gymnasium.single import WorldEnv

DICT = {"name": "navigation", "observation_form": "dict"}


def test_flat_box_is_bounded():
    env = WorldEnv("sparse_circles")
    space = env.observation_space
    assert isinstance(space, Box)
    assert space.dtype == np.float32
    assert (space.low >= -1.0).all()
    assert (space.high <= 1.0).all()
    assert (space.low < space.high).all()
    assert env.observation_space is space
    action_space = env.action_space
    assert isinstance(action_space, Box)
    assert (action_space.low.tolist(), action_space.high.tolist()) == ([-1.0, -1.0], [1.0, 1.0])


def test_dict_holds_the_flat_observation_in_parts():
    flat, parts = WorldEnv("sparse_circles"), WorldEnv("sparse_circles", task=DICT)
    assert isinstance(parts.observation_space, Dict)
    names = [name for name, _, _ in parts.worlds.episodes.observation_terms]
    whole, pieces = flat.reset(seed=0)[0], parts.reset(seed=0)[0]
    assert pieces in parts.observation_space
    np.testing.assert_array_equal(np.concatenate([pieces[name] for name in names]), whole)


def test_discrete_actions():
    env = WorldEnv("sparse_circles", task={"name": "navigation", "action": {"name": "discrete"}})
    assert isinstance(env.action_space, Discrete)
    env.reset(seed=0)
    for action in (0, np.int64(1), np.array(2)):
        env.step(action)
