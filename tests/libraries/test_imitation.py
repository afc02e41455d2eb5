"""imitation: an actor learns from recorded demonstrations, and drives the native batch."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from needed import library

import irsim_gym


@pytest.fixture(scope="module", autouse=True)
def imitation():
    return library("imitation")


@pytest.fixture(scope="module")
def transitions(tmp_path_factory):
    from imitation.data.types import Transitions

    file = tmp_path_factory.mktemp("shown") / "demo.npz"
    return Transitions(**irsim_gym.record_demonstrations("empty_goal", "dash", file, levels=30).transitions())


def test_behaviour_is_cloned(transitions):
    from imitation.algorithms.bc import BC

    env = irsim_gym.make("empty_goal")
    cloner = BC(
        observation_space=env.observation_space,
        action_space=env.action_space,
        rng=np.random.default_rng(0),
        demonstrations=transitions,
    )

    def error():
        return np.abs(cloner.policy.predict(transitions.obs, deterministic=True)[0] - transitions.acts).mean()

    before = error()
    cloner.train(n_epochs=5, progress_bar=False)
    assert error() < 0.5 * before


def test_an_adversary_trains_on_the_native_batch(transitions):
    from imitation.algorithms.adversarial.gail import GAIL
    from imitation.rewards.reward_nets import BasicRewardNet
    from stable_baselines3 import PPO

    env = irsim_gym.sb3.make_vec_env("empty_goal", 4, seed=0, max_steps=20)
    learner = PPO("MlpPolicy", env, n_steps=16, batch_size=32, n_epochs=1, device="cpu")
    reward = BasicRewardNet(env.observation_space, env.action_space)
    before = [one.detach().clone() for one in learner.policy.parameters()]
    trainer = GAIL(
        demonstrations=transitions,
        demo_batch_size=32,
        venv=env,
        gen_algo=learner,
        reward_net=reward,
        gen_train_timesteps=64,
        allow_variable_horizon=True,
    )
    trainer.train(128)
    assert any((one != other).any() for one, other in zip(before, learner.policy.parameters(), strict=True))
    del trainer
    gc.collect()  # it leaves files of its logger open, which warns
