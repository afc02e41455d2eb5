"""Tianshou: the native batch under its collectors, and a trainer's update."""

from __future__ import annotations

import library_pages as pages
import numpy as np
import pytest
from needed import library
from scenes import ENDS, paid_alone, team
from scenes import LIMIT as TEAM_LIMIT

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


def test_its_own_vector_environments_take_single_ones(page):
    from tianshou.env import DummyVectorEnv

    envs = DummyVectorEnv([lambda: irsim_gym.make("empty_goal", max_steps=LIMIT)] * 2)
    envs.reset()
    steps = [envs.step(np.zeros((2, 2), np.float32)) for _ in range(LIMIT)]
    assert [step[3].tolist() for step in steps] == [[False, False]] * (LIMIT - 1) + [[True, True]]
    assert [info["steps"] for info in steps[-1][4]] == [LIMIT, LIMIT]


@pytest.mark.parametrize("black_death", [False, True])
def test_a_team_ends_with_its_first_robot_unless_all_stay(page, black_death):
    from pettingzoo.utils.conversions import parallel_to_aec
    from tianshou.env import PettingZooEnv

    env = PettingZooEnv(parallel_to_aec(irsim_gym.parallel_env(team(), black_death=black_death)))
    env.reset(seed=0)
    ended, n_steps, paid = False, 0, np.zeros(len(ENDS))
    while not ended:
        _, rewards, terminated, truncated, _ = env.step(np.zeros(2, np.float32))
        ended, n_steps, paid = terminated or truncated, n_steps + 1, paid + rewards
    assert n_steps == len(ENDS) * (TEAM_LIMIT if black_death else ENDS["robot_0"])
    if black_death:
        np.testing.assert_allclose(paid, list(paid_alone().values()), rtol=1e-6)
