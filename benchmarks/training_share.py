"""How PPO's training time divides into simulator, task, policy and update."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

import irsim_gym as ig
from irsim_gym.training import load_hyperparameters


class TimedWorlds(VecEnvWrapper):
    """Sums up the CPU seconds that steps take."""

    def __init__(self, venv: VecEnv) -> None:
        super().__init__(venv)
        self.seconds = 0.0

    def reset(self) -> VecEnvObs:
        """Begin episodes in all worlds."""
        return self.venv.reset()

    def step_wait(self) -> VecEnvStepReturn:
        """Step, and count the time."""
        begin = time.process_time()
        result = self.venv.step_wait()
        self.seconds += time.process_time() - begin
        return result


class TimedSimulator:
    """Sums up the CPU seconds that the simulator takes within a step: moving, sensing, clearances, new levels."""

    def __init__(self, simulation: ig.Simulation) -> None:
        self.seconds = 0.0
        for name in ("advance", "begin", "clearance"):
            setattr(simulation, name, self._timed(getattr(simulation, name)))

    def _timed(self, method: Callable[..., None]) -> Callable[..., None]:
        def timed(*arguments: Any, **options: Any) -> None:
            begin = time.process_time()
            method(*arguments, **options)
            self.seconds += time.process_time() - begin

        return timed


class TimedRollouts(BaseCallback):
    """Sums up the CPU seconds of rollouts, simulator included."""

    def __init__(self) -> None:
        super().__init__()
        self.seconds = 0.0
        self._begin = 0.0

    def _on_rollout_start(self) -> None:
        self._begin = time.process_time()

    def _on_rollout_end(self) -> None:
        self.seconds += time.process_time() - self._begin

    def _on_step(self) -> bool:
        return True


def measure(name: str, steps: int) -> dict[str, float]:
    """Train for some steps with the shipped settings and return the shares of CPU time.

    Args:
        name: The scenario.
        steps: Number of steps.
    """
    wanted = load_hyperparameters("ppo", f"irsim_gym/{name}-v0")
    torch.set_num_threads(wanted.torch_threads)
    warm = ig.sb3.make_vec_env(name, 2, seed=0)
    warm.reset()
    warm.step(warm.action_space.sample()[None].repeat(2, 0))
    worlds = ig.sb3.make_vec_env(name, wanted.n_envs, seed=0)
    simulator, env = TimedSimulator(worlds.worlds.episodes.simulation), TimedWorlds(worlds)
    model = PPO("MlpPolicy", env, seed=0, device="cpu", **wanted.algorithm_arguments())
    rollouts = TimedRollouts()
    begin = time.process_time()
    model.learn(steps, callback=rollouts)
    total = time.process_time() - begin
    return {
        "worlds": env.num_envs,
        "steps": model.num_timesteps,
        "steps_per_cpu_s": model.num_timesteps / total,
        "simulator_share": simulator.seconds / total,
        "task_and_adapter_share": (env.seconds - simulator.seconds) / total,
        "policy_share": (rollouts.seconds - env.seconds) / total,
        "update_share": 1.0 - rollouts.seconds / total,
        "simulator_us_per_step": 1e6 * simulator.seconds / model.num_timesteps,
        "environment_us_per_step": 1e6 * env.seconds / model.num_timesteps,
    }
