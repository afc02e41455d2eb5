"""Whoever learns from robots that wait is told so, and nobody else."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from sb3_contrib import RecurrentPPO
from stable_baselines3 import A2C, PPO, SAC
from stable_baselines3.common.callbacks import EvalCallback
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize
from team_tools import KNOWN, LIMIT

from irsim_gym import sb3
from irsim_gym.errors import WaitingRobotsWarning

ON_POLICY = {"n_steps": LIMIT, "device": "cpu"}
ROWS = 3 * LIMIT


def team(**kwargs):
    return sb3.make_multi_agent_vec_env(KNOWN, 1, seed=0, render_mode=None, **kwargs)


def plain(algorithm, env):
    if algorithm is SAC:
        return SAC("MlpPolicy", env, learning_starts=10**6, buffer_size=200, device="cpu")
    sizes = {} if algorithm is A2C else {"batch_size": ROWS}
    return algorithm("MlpLstmPolicy" if algorithm is RecurrentPPO else "MlpPolicy", env, **ON_POLICY, **sizes)


@pytest.mark.parametrize(
    ("algorithm", "buffer", "wrapped"),
    [
        (PPO, "RolloutBuffer", False),
        (A2C, "RolloutBuffer", True),
        (SAC, "ReplayBuffer", False),
        (RecurrentPPO, "RecurrentRolloutBuffer", True),
    ],
)
def test_an_algorithm_with_plain_buffers_is_told_once(algorithm, buffer, wrapped):
    env = team()
    model = plain(algorithm, VecNormalize(env) if wrapped else env)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        model.learn(3 * ROWS)
    found = [warning for warning in told if warning.category is WaitingRobotsWarning]
    assert len(found) == 1
    assert f"{buffer} keeps their rows" in str(found[0].message)
    assert "buffers_for" in str(found[0].message)
    assert env.idle_share > 0.0


def test_a_monitor_that_would_count_waiting_is_told_once():
    env = team()
    monitored = VecNormalize(VecMonitor(env))
    monitored.reset()
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        for _ in range(3 * LIMIT):
            monitored.step(np.zeros((3, 2), np.float32))
    (found,) = [warning for warning in told if warning.category is WaitingRobotsWarning]
    assert "VecMonitor counts the waiting" in str(found.message)


def test_nobody_waits_in_the_other_mode():
    env = team(respawn=True)
    plain(PPO, env).learn(2 * ROWS)
    assert env.idle_share == 0.0


def test_looking_on_is_not_learning():
    env = team()
    model = PPO("MlpPolicy", env, **ON_POLICY, batch_size=ROWS, **sb3.buffers_for(PPO, env))
    model.learn(ROWS)
    watched = team()
    evaluate_policy(model, watched, n_eval_episodes=6)
    for _ in range(LIMIT):
        watched.step(np.zeros((3, 2), np.float32))
    learner = plain(PPO, team(respawn=True))
    learner.learn(ROWS, callback=EvalCallback(watched, n_eval_episodes=3, eval_freq=LIMIT, verbose=0))
    assert env.idle_share > 0.0
    assert watched.idle_share > 0.0
    with pytest.warns(WaitingRobotsWarning):  # what was watched is learnt from at last
        plain(PPO, watched).learn(ROWS)
