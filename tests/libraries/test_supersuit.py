"""SuperSuit: teams as batches for Stable-Baselines3."""

from __future__ import annotations

import numpy as np
import pytest
from needed import library
from scenes import FORMS, LIMIT, paid_alone, team

import irsim_gym


@pytest.fixture(scope="module")
def supersuit():
    return library("supersuit")


def test_a_vector_environment(supersuit):
    """Rewards are those of the agents, and the world ends, and begins anew, in the step in which the last one ends."""
    env = supersuit.pettingzoo_env_to_vec_env_v1(irsim_gym.parallel_env(team(), black_death=True))
    env.reset(seed=0)
    paid, ends = np.zeros(3), []
    for step in range(1, 2 * LIMIT + 1):
        _, rewards, terminated, truncated, infos = env.step(np.zeros((3, 2), np.float32))
        paid += rewards
        if (terminated | truncated).any():
            ends.append(step)
            assert terminated.tolist() == [1, 1, 0]
            assert truncated.tolist() == [0, 0, 1]
            assert all("terminal_observation" in info for info in infos)
    assert ends == [LIMIT, 2 * LIMIT]
    np.testing.assert_allclose(paid, 2 * np.array(list(paid_alone().values())), rtol=1e-5)


@pytest.mark.parametrize("form", FORMS)
def test_other_forms(supersuit, form):
    env = supersuit.pettingzoo_env_to_vec_env_v1(irsim_gym.parallel_env(team(**FORMS[form]), black_death=True))
    env.reset(seed=0)
    actions = np.array([env.action_space.sample() for _ in range(3)])
    assert any(env.step(actions)[2].any() for _ in range(LIMIT))


def test_stable_baselines3_trains(supersuit):
    stable_baselines3 = library("stable_baselines3")
    env = supersuit.pettingzoo_env_to_vec_env_v1(irsim_gym.parallel_env(team(), black_death=True))
    env = supersuit.concat_vec_envs_v1(env, 2, base_class="stable_baselines3")
    model = stable_baselines3.PPO("MlpPolicy", env, n_steps=24, batch_size=36, n_epochs=1, device="cpu")
    before = [one.clone() for one in model.policy.parameters()]
    model.learn(144)
    assert model.num_timesteps == 144
    assert any((one != other).any() for one, other in zip(before, model.policy.parameters(), strict=True))


def test_its_own_black_death_ends_a_step_late(supersuit):
    """So that the page says so only as long as it is true."""
    env = supersuit.black_death_v3(irsim_gym.parallel_env(team()))
    env.reset(seed=0)
    ends = []
    for step in range(1, LIMIT + 2):
        observations, rewards, terminations, *_ = env.step(dict.fromkeys(env.agents, np.zeros(2)))
        ends += [step] * all(terminations.values())
    assert ends == [LIMIT + 1]
    assert not any(seen.any() for seen in observations.values())
    assert set(rewards.values()) == {0.0}
