"""Tianshou: the native batch under its collectors, and a trainer's update."""

from __future__ import annotations

import library_pages as pages
import numpy as np
import pytest
from needed import library

import irsim_gym

LIMIT = 12


@pytest.fixture(scope="module")
def page():
    library("tianshou")
    return pages.shown("tianshou")


@pytest.fixture
def envs(page):
    return page["Worlds"](irsim_gym.make_batch("empty_goal", 3, max_steps=LIMIT, autoreset=False))


def test_steps_are_those_of_make_vec(envs):
    """Restarts of some worlds included, in which a vector environment of Gymnasium goes on with the same levels."""
    plain = irsim_gym.make_vec("empty_goal", 3, max_steps=LIMIT, autoreset_mode="Disabled")
    envs.seed(4)
    np.testing.assert_array_equal(envs.reset()[0], plain.reset(seed=4)[0])
    rng = np.random.default_rng(0)
    for _ in range(2 * LIMIT):
        actions = rng.uniform(-1, 1, (3, 2)).astype(np.float32)
        mine, theirs = envs.step(actions), plain.step(actions)
        for one, other in zip(mine[:4], theirs[:4], strict=True):
            np.testing.assert_array_equal(one, other)
        ended = mine[2] | mine[3]
        if ended.any():
            begun = envs.reset(np.flatnonzero(ended))[0]
            np.testing.assert_array_equal(begun, plain.reset(options={"reset_mask": ended})[0][ended])


def test_it_collects_and_learns(envs, page):
    from tianshou.data import Collector, VectorReplayBuffer
    from tianshou.utils.torch_utils import policy_within_training_step

    learner = page["learner"](envs)
    collector = Collector(learner, envs, VectorReplayBuffer(300, 3))
    collector.reset()
    found = collector.collect(n_step=3 * 2 * LIMIT)
    assert found.n_collected_episodes == 6
    assert found.lens.tolist() == [LIMIT] * 6
    assert collector.buffer.truncated.sum() == 6
    before = [one.detach().clone() for one in learner.policy.parameters()]
    with policy_within_training_step(learner.policy):
        learner.update(buffer=collector.buffer, batch_size=36, repeat=1)
    assert any((one != other).any() for one, other in zip(before, learner.policy.parameters(), strict=True))


def test_a_number_of_episodes_leaves_worlds_that_are_done_alone(envs, page):
    from tianshou.data import Collector, VectorReplayBuffer

    collector = Collector(page["learner"](envs), envs, VectorReplayBuffer(300, 3))
    collector.reset()
    assert collector.collect(n_episode=4).lens.tolist() == [LIMIT] * 4
