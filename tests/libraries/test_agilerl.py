"""AgileRL: its vector environments in processes, and some steps of its trainers."""

from __future__ import annotations

import numpy as np
import pytest
from needed import library
from scenes import ENDS, LIMIT, paid_alone, team

import irsim_gym


@pytest.fixture(scope="module", autouse=True)
def agilerl():
    return library("agilerl")


def whole():
    return irsim_gym.parallel_env(team(), black_death=True)


def leaving():
    return irsim_gym.parallel_env(team())


@pytest.fixture(params=[whole, leaving])
def envs(request):
    from agilerl.vector.pz_async_vec_env import AsyncPettingZooVecEnv

    made = AsyncPettingZooVecEnv([request.param] * 2)
    made.is_whole = request.param is whole
    yield made
    made.close()


def test_processes(envs):
    """An episode pays what it pays alone; AgileRL marks agents that have left with NaN."""
    envs.reset(seed=0)
    still = {name: np.zeros((2, 2), np.float32) for name in ENDS}
    steps = [envs.step(still) for _ in range(LIMIT + 1)]
    for name, end in ENDS.items():
        rewards = np.array([step[1][name] for step in steps])[:LIMIT]
        np.testing.assert_allclose(np.nansum(rewards, axis=0), [paid_alone()[name]] * 2, rtol=1e-6)
        assert np.isnan(rewards[end:]).all() != envs.is_whole or end == LIMIT
    assert (steps[-1][4]["robot_2"]["steps"] == 1).all()  # a new episode


@pytest.mark.parametrize("envs", [whole], indirect=True)
def test_ippo_learns(envs):
    """With a whole team alone: IPPO learns from the NaN of agents that have left, and its weights become NaN."""
    from agilerl.algorithms.ippo import IPPO
    from agilerl.training.train_multi_agent_on_policy import train_multi_agent_on_policy

    names = list(ENDS)
    spaces = [envs.single_observation_space(name) for name in names], [envs.single_action_space(name) for name in names]
    agent = IPPO(*spaces, agent_ids=names, learn_step=36, batch_size=18, update_epochs=1)
    before = [one.detach().clone() for actor in agent.actors.values() for one in actor.parameters()]
    train_multi_agent_on_policy(
        envs, "team", "IPPO", [agent], max_steps=72, evo_steps=72, eval_steps=LIMIT, sum_scores=False, verbose=False
    )
    after = [one.detach() for actor in agent.actors.values() for one in actor.parameters()]
    assert all(one.isfinite().all() for one in after)
    assert any((one != other).any() for one, other in zip(before, after, strict=True))


def test_maddpg_learns(envs):
    from agilerl.algorithms.maddpg import MADDPG
    from agilerl.components.replay_buffer import ReplayBuffer
    from agilerl.training.train_multi_agent_off_policy import train_multi_agent_off_policy

    names = list(ENDS)
    spaces = [envs.single_observation_space(name) for name in names], [envs.single_action_space(name) for name in names]
    agent = MADDPG(*spaces, agent_ids=names, learn_step=4, batch_size=8, vect_noise_dim=2)
    memory = ReplayBuffer(256)
    before = [one.detach().clone() for actor in agent.actors.values() for one in actor.parameters()]
    train_multi_agent_off_policy(
        envs, "team", "MADDPG", [agent], memory, max_steps=72, evo_steps=72, eval_steps=LIMIT, verbose=False
    )
    after = [one.detach() for actor in agent.actors.values() for one in actor.parameters()]
    assert all(one.isfinite().all() for one in after)
    assert any((one != other).any() for one, other in zip(before, after, strict=True))
