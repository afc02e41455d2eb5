"""PPO and SAC with S1 against the same with an environment that does nothing: what a learner waits for."""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np
import torch
from effort import Effort, Figures
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn
from standard_worlds import s1

import irsim_gym as ig

SIZES = (8, 64, 512)
ROLLOUT, MINIBATCH = 8192, 1024
UPDATES = 3
SAC_STEPS = 100
"""Steps of all worlds in a round of SAC; each is followed by as many updates as the shipped settings ask for."""
MOST_ROUNDS = 5


class NothingVecEnv(VecEnv):
    """Worlds that never change: the same observation, no reward, no end."""

    def __init__(self, like: VecEnv) -> None:
        super().__init__(like.num_envs, like.observation_space, like.action_space)
        shape = (self.num_envs, *(like.observation_space.shape or ()))
        self._observation = np.zeros(shape, np.float32)

    def reset(self) -> Any:
        """Return the observation."""
        return self._observation.copy()

    def step_async(self, actions: Any) -> None:
        """Take the actions, for nothing."""

    def step_wait(self) -> VecEnvStepReturn:
        """Return fresh arrays, as an environment has to."""
        n = self.num_envs
        return self._observation.copy(), np.zeros(n, np.float32), np.zeros(n, np.bool_), [{} for _ in range(n)]

    def close(self) -> None:
        """Nothing to free."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return None for everything but the render mode's absence."""
        return [None] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Nothing is kept."""

    def env_method(self, method_name: str, *arguments: Any, indices: Any = None, **options: Any) -> list[Any]:
        """There are no methods."""
        return [None] * self.num_envs

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Nothing is wrapped."""
        return [False] * self.num_envs


def measure(effort: Effort) -> Figures:
    """Return frames per CPU second of both, in turns, and the ratio of their medians, by algorithm and batch."""
    torch.set_num_threads(1)
    figures: Figures = {}
    for n_worlds in effort.sizes(SIZES):
        env = ig.sb3.make_vec_env(s1(), n_worlds, seed=0, render_mode=None)
        envs = {"s1": env, "noop": NothingVecEnv(env)}
        figures |= _shares("", n_worlds, {name: _ppo(one) for name, one in envs.items()}, UPDATES * ROLLOUT, effort)
        models = {name: _sac(one) for name, one in envs.items()}
        figures |= _shares("sac_", n_worlds, models, SAC_STEPS * n_worlds, effort)
    return figures


def _shares(prefix: str, n_worlds: int, models: dict[str, BaseAlgorithm], frames: int, effort: Effort) -> Figures:
    """Let both learn for so many frames in turns."""
    rates: dict[str, list[float]] = {name: [] for name in models}
    for _ in range(min(MOST_ROUNDS, effort.rounds)):
        for name, model in models.items():
            begin = time.process_time()
            model.learn(frames, reset_num_timesteps=False)
            rates[name].append(frames / (time.process_time() - begin))
    medians = {name: statistics.median(found) for name, found in rates.items()}
    figures: Figures = {f"{prefix}{name}_{n_worlds}_worlds_per_cpu_s": rate for name, rate in medians.items()}
    return figures | {f"{prefix}{n_worlds}_worlds_share_of_noop": medians["s1"] / medians["noop"]}


def _ppo(env: VecEnv) -> PPO:
    model = PPO("MlpPolicy", env, n_steps=ROLLOUT // env.num_envs, batch_size=MINIBATCH, n_epochs=5, device="cpu")
    model.learn(ROLLOUT)
    return model


def _sac(env: VecEnv) -> SAC:
    """Return SAC with the shipped settings, past its first steps without updates."""
    model = SAC(
        "MlpPolicy",
        env,
        learning_starts=env.num_envs,
        buffer_size=50_000,
        gradient_steps=4,
        policy_kwargs={"net_arch": [128, 128]},
        device="cpu",
    )
    model.learn(4 * env.num_envs)
    return model
