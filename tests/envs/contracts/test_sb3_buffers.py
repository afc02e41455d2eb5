"""What learning gets from teams: advantages, targets and rows, against sums written out for each agent."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecNormalize
from team_tools import ARRIVES, COLLIDES, KNOWN, LIMIT, MEET, Recorder, episodes_of

import irsim_gym
from irsim_gym import sb3

GAMMA, LAMBDA = 0.9, 0.8


def team(scenario=MEET, n_worlds=4, **kwargs):
    return sb3.make_multi_agent_vec_env(scenario, n_worlds, seed=0, render_mode=None, **kwargs)


def ppo(env, kind=sb3.MaskedPPO, **kwargs):
    options = {"n_steps": 24, "batch_size": 48, "n_epochs": 1, "gamma": GAMMA, "gae_lambda": LAMBDA}
    policy = "MultiInputPolicy" if hasattr(env.observation_space, "spaces") else "MlpPolicy"
    return kind(policy, env, seed=0, device="cpu", **{**options, **kwargs})


def value(model, observation):
    with torch.no_grad():
        return model.policy.predict_values(model.policy.obs_to_tensor(observation)[0]).item()


def sums_of_an_episode(model, seen, slot, steps, ended):
    """Advantages and targets of an episode from their definition, with the policy that the rollout was made with."""
    rewards, values = (seen.table(name)[steps, slot].astype(float) for name in ("rewards", "values"))
    after = 0.0
    if not ended:
        after = seen.last_values[slot]
    elif seen.infos[steps[-1]][slot]["TimeLimit.truncated"]:
        after = value(model, seen.infos[steps[-1]][slot]["terminal_observation"])
    following = np.append(values[1:], after)
    errors = rewards + GAMMA * following - values
    advantages = [sum((GAMMA * LAMBDA) ** k * error for k, error in enumerate(errors[i:])) for i in range(len(errors))]
    return np.array(advantages), np.array(advantages) + values


class Frozen(sb3.MaskedPPO):
    """Collects and hands out, but does not change the policy."""

    def train(self):
        self.batches = list(self.rollout_buffer.get(self.batch_size))


@pytest.mark.parametrize("respawn", [False, True])
@pytest.mark.parametrize("form", ["flat", "dict"])
def test_advantages_are_those_of_each_agent_alone(respawn, form):
    env = team(respawn=respawn, max_steps=20, task={**MEET["task"], "name": "navigation", "observation_form": form})
    seen = Recorder()
    policy = "MultiInputPolicy" if form == "dict" else "MlpPolicy"
    model = Frozen(
        policy, env, seed=0, device="cpu", n_steps=64, batch_size=64, gamma=GAMMA, gae_lambda=LAMBDA,
    )  # fmt: skip
    model.learn(64 * env.num_envs, callback=seen)
    dones, acted = seen.table("dones"), seen.table("acted")
    expected, ends, cuts = [], 0, 0
    for slot, steps, ended in episodes_of(dones, acted):
        advantages, targets = sums_of_an_episode(model, seen, slot, steps, ended)
        rows = seen.table("log_probs")[steps, slot], seen.table("values")[steps, slot]
        expected += zip(*rows, advantages, targets, strict=True)
        ends += ended
        cuts += ended and seen.infos[steps[-1]][slot]["TimeLimit.truncated"]
    assert ends > 20
    assert 0 < cuts < ends
    given = [
        row
        for batch in model.batches
        for row in zip(
            *(getattr(batch, name).tolist() for name in ("old_log_prob", "old_values", "advantages", "returns")),
            strict=True,
        )
    ]
    assert len(given) == len(expected) == acted.sum()
    np.testing.assert_allclose(sorted(given), sorted(expected), rtol=1e-4, atol=1e-4)
    assert acted.all() == (respawn)
    sizes = [len(batch.returns) for batch in model.batches]
    assert max(sizes) <= 64
    assert max(sizes) - min(sizes) < len(sizes)


@pytest.mark.parametrize("respawn", [False, True])
def test_targets_of_a_task_of_known_value(respawn):
    """Arrival and collision end the sum of -1s; the time limit goes on with the value of where it has cut."""
    env = team(KNOWN, 2, respawn=respawn)
    seen, steps = Recorder(), 2 * LIMIT
    model = Frozen(
        "MlpPolicy", env, seed=0, device="cpu", n_steps=steps, batch_size=12, gamma=GAMMA, gae_lambda=1.0,
    )  # fmt: skip
    model.learn(steps * env.num_envs, callback=seen)

    def worth(left):
        return -(1.0 - GAMMA**left) / (1.0 - GAMMA)

    for slot in range(6):
        length = (ARRIVES, COLLIDES, LIMIT)[slot % 3]
        period = LIMIT if not respawn else length
        for step in range(steps):
            since = step % period
            acts = since < length
            assert seen.table("acted")[step, slot] == acts
            if not acts:
                continue
            left, last = length - since, step - since + length - 1
            target = worth(left)
            if last >= steps:
                left = steps - step
                target = worth(left) + GAMMA**left * seen.last_values[slot]
            elif slot % 3 == 2:
                target += GAMMA**left * value(model, seen.infos[last][slot]["terminal_observation"])
            assert seen.returns[step, slot] == pytest.approx(target, abs=1e-5)
    waiting = (2 * LIMIT - ARRIVES - COLLIDES) / (3 * LIMIT) if not respawn else 0.0
    assert env.idle_share == pytest.approx(waiting)
    assert len(torch.cat([batch.returns for batch in model.batches])) == round((1.0 - waiting) * steps * 6)


def test_without_waiting_agents_all_is_as_in_stable_baselines():
    """A respawning team has no idle rows: masked or not, the weights are the same."""
    weights = []
    for kind in (sb3.MaskedPPO, PPO):
        model = ppo(team(respawn=True, max_steps=20), kind, n_epochs=2)
        model.learn(1000)
        weights.append(torch.cat([p.detach().flatten() for p in model.policy.parameters()]))
    assert torch.equal(*weights)


@pytest.mark.filterwarnings("ignore::irsim_gym.errors.WaitingRobotsWarning")
def test_waiting_rows_would_have_changed_the_weights():
    weights = []
    for kind in (sb3.MaskedPPO, sb3.MaskedPPO, PPO):
        model = ppo(team(max_steps=20), kind, n_epochs=2)
        model.learn(1000)
        weights.append(torch.cat([p.detach().flatten() for p in model.policy.parameters()]))
    assert torch.equal(weights[0], weights[1])
    assert not torch.equal(weights[0], weights[2])


def test_a2c_learns_without_minibatches():
    env = team(max_steps=10)
    model = sb3.MaskedA2C("MlpPolicy", env, seed=0, device="cpu", n_steps=16)
    model.learn(16 * env.num_envs)
    assert 0 < len(model.rollout_buffer.values) == model.rollout_buffer.acted.sum() < 16 * env.num_envs


def test_algorithms_that_cannot_leave_out_waiting_are_refused():
    env, single = team(), sb3.make_vec_env("sparse_circles", 2, seed=0, render_mode=None)
    with pytest.raises(TypeError, match="WorldVecEnv does not say which slots acted"):
        ppo(single, n_steps=4, batch_size=8).learn(8)
    model = ppo(env, PPO, n_steps=4, batch_size=8, rollout_buffer_class=sb3.MaskedRolloutBuffer)
    with pytest.raises(TypeError, match=r"use sb3\.MaskedPPO"):
        model.learn(8)


def actions(rng, env):
    return rng.uniform(-1, 1, (env.num_envs, 2)).astype(np.float32)


@pytest.mark.filterwarnings("ignore::irsim_gym.errors.WaitingRobotsWarning")
@pytest.mark.parametrize("respawn", [False, True])
def test_statistics_of_normalisation_are_those_of_experience(respawn):
    plain = team(respawn=respawn, max_steps=20)
    env = sb3.MaskedVecNormalize(team(respawn=respawn, max_steps=20), gamma=GAMMA)
    observations, rng = [plain.reset()], np.random.default_rng(0)
    env.reset()
    returns, sums = [], np.zeros(plain.num_envs)
    for _ in range(60):
        chosen = actions(rng, plain)
        seen, rewards, dones, _ = plain.step(chosen)
        env.step(chosen)
        observations.append(seen[plain.acting])
        sums = np.where(plain.acted, GAMMA * sums + rewards, sums)
        returns.append(np.array(sums[plain.acted]))
        sums[dones] = 0.0
    rows, discounted = np.concatenate(observations), np.concatenate(returns)
    np.testing.assert_allclose(env.obs_rms.mean, rows.mean(axis=0), atol=1e-5)
    np.testing.assert_allclose(env.obs_rms.var, rows.var(axis=0), atol=1e-5)
    np.testing.assert_allclose(env.ret_rms.mean, discounted.mean(), rtol=1e-4)
    np.testing.assert_allclose(env.ret_rms.var, discounted.var(), rtol=1e-3)
    assert (len(rows) == 61 * plain.num_envs) == (respawn)


def test_normalisation_is_that_of_stable_baselines_where_nobody_waits():
    ours, theirs = (wrapper(team(respawn=True, max_steps=20)) for wrapper in (sb3.MaskedVecNormalize, VecNormalize))
    rng = np.random.default_rng(0)
    np.testing.assert_array_equal(ours.reset(), theirs.reset())
    for _ in range(50):
        chosen = actions(rng, ours)
        here, there = ours.step(chosen), theirs.step(chosen)
        for one, other in zip(here[:3], there[:3], strict=True):
            np.testing.assert_array_equal(one, other)
        for one, other in zip(here[3], there[3], strict=True):
            if "terminal_observation" in other:
                np.testing.assert_array_equal(one["terminal_observation"], other["terminal_observation"])


@pytest.mark.parametrize("wrapper", [VecNormalize, sb3.MaskedVecNormalize])
def test_ppo_learns_under_normalisation(wrapper, tmp_path):
    env = wrapper(team(max_steps=20))
    model = ppo(env)
    model.learn(600)
    env.save(str(tmp_path / "statistics.pkl"))
    again = wrapper.load(str(tmp_path / "statistics.pkl"), team(max_steps=20))
    assert type(again) is wrapper
    assert again.obs_rms.count == env.obs_rms.count
    model.set_env(again)
    model.learn(600)
    assert torch.isfinite(torch.cat([p.detach().flatten() for p in model.policy.parameters()])).all()


def test_package_shows_the_buffers():
    assert {"make_multi_agent_vec_env", "MaskedRolloutBuffer"} <= set(irsim_gym.sb3.__all__)
