"""Whoever may learn from robots that wait is warned once."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from stable_baselines3 import A2C, PPO, SAC
from stable_baselines3.common.callbacks import EvalCallback
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecNormalize
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
    return algorithm("MlpPolicy", env, **ON_POLICY, **sizes)


def warnings_of(env, steps):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        steps(env)
    return [str(one.message) for one in caught if one.category is WaitingRobotsWarning]


@pytest.mark.parametrize(("algorithm", "wrapped"), [(PPO, False), (A2C, True), (SAC, False)], ids=str)
def test_an_algorithm_with_plain_buffers_is_warned_once(algorithm, wrapped):
    env = team()
    model = plain(algorithm, VecNormalize(env) if wrapped else env)
    (message,) = warnings_of(env, lambda _: model.learn(3 * ROWS))
    assert "sb3.MaskedPPO" in message
    assert "respawn=True" in message
    assert env.idle_share > 0.0


def play(env):
    env.reset()
    for _ in range(3 * LIMIT):
        env.step(np.zeros((3, 2), np.float32))


def test_a_loop_of_ones_own_is_warned_once_unless_it_says_that_it_knows():
    (message,) = warnings_of(team(), play)
    assert "env.leaves_out_waiting = True" in message
    env = team()
    env.leaves_out_waiting = True
    assert warnings_of(env, play) == []
    assert warnings_of(team(respawn=True), play) == []


def test_masked_learning_and_evaluation_are_not_warned():
    env = team()
    model = sb3.MaskedPPO("MlpPolicy", env, **ON_POLICY, batch_size=ROWS)
    model.learn(ROWS)
    watched = team()
    evaluate_policy(model, VecNormalize(watched), n_eval_episodes=6)
    learner = plain(PPO, team(respawn=True))
    learner.learn(ROWS, callback=EvalCallback(watched, n_eval_episodes=3, eval_freq=LIMIT, verbose=0))
    assert env.idle_share > 0.0
    assert watched.idle_share > 0.0
    with pytest.warns(WaitingRobotsWarning):  # the next episodes belong to no evaluation
        plain(PPO, watched).learn(ROWS)
