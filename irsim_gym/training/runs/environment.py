"""The vectorised environment of a run, and its state in a checkpoint."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecNormalize, unwrap_vec_normalize
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from irsim_gym import sb3
from irsim_gym.training.settings.mixture import shared_worlds
from irsim_gym.training.settings.run import Settings


class ScaledReward(VecEnvWrapper):
    """Multiplies rewards by a factor. The statistics of episodes keep the original rewards."""

    def __init__(self, venv: VecEnv, scale: float) -> None:
        super().__init__(venv)
        self.scale = np.float32(scale)

    def reset(self) -> VecEnvObs:
        """Reset all worlds."""
        return self.venv.reset()

    def step_wait(self) -> VecEnvStepReturn:
        """Return the results of the step, with scaled rewards."""
        observations, rewards, dones, infos = self.venv.step_wait()
        return observations, rewards * self.scale, dones, infos


def build_environment(settings: Settings, normalization: Path | None = None) -> VecEnv:
    """Make the environment of a run, with its wrappers.

    Args:
        normalization: File with saved statistics of ``VecNormalize``; None to start without.
    """
    hyper = settings.hyperparameters
    env: VecEnv = make_worlds(settings, hyper.n_envs)
    if hyper.reward_scale != 1.0:
        env = ScaledReward(env, hyper.reward_scale)
    if hyper.normalize is not None:
        arguments = {"gamma": hyper.arguments.get("gamma", 0.99), **hyper.normalize}
        kind = VecNormalize if hyper.team is None else sb3.MaskedVecNormalize
        env = kind(env, **arguments) if normalization is None else kind.load(str(normalization), env)
    return env


def make_worlds(settings: Settings, n_envs: int, max_steps: int | None = None) -> Any:
    """Make the environment of a run, without its wrappers.

    Args:
        max_steps: Time limit [steps]; None for the task's own.
    """
    if settings.mixture:
        counts = shared_worlds([part.share for part in settings.mixture], n_envs)
        parts = zip(settings.names, settings.parts(), counts, strict=True)
        return sb3.MixtureVecEnv({name: make_worlds(part, count, max_steps) for name, part, count in parts})
    mode = settings.hyperparameters.team
    seed = settings.first_level
    options: dict[str, Any] = {"task": settings.task, "max_steps": max_steps, "render_mode": None}
    options |= {"strict": settings.strict, **settings.parameters}
    if mode is None:
        return sb3.make_vec_env(settings.scenario, n_envs, seed, **options)
    return sb3.make_multi_agent_vec_env(settings.scenario, n_envs, seed, respawn=mode == "respawn", **options)


def compile_kernels(settings: Settings) -> None:
    """Compile all kernels by stepping a small batch to the end of its episodes, before the training time starts."""
    env = make_worlds(settings, max(2, len(settings.mixture)), max_steps=1)
    env.reset()
    env.step(np.stack([env.action_space.sample() for _ in range(env.num_envs)]))
    env.close()


def worlds_state(env: VecEnv) -> dict[str, Any]:
    """Return the state of all worlds, which may be within episodes."""
    normalization = unwrap_vec_normalize(env)
    return {"worlds": pickle.dumps(env.unwrapped), "returns": None if normalization is None else normalization.returns}


def restore_worlds(env: VecEnv, state: dict[str, Any]) -> VecEnv:
    """Replace the worlds of a newly built environment by saved ones, and return the environment."""
    worlds: VecEnv = pickle.loads(state["worlds"])
    if not isinstance(env, VecEnvWrapper):
        env.close()
        return worlds
    innermost = env
    while isinstance(innermost.venv, VecEnvWrapper):
        innermost = innermost.venv
    innermost.venv.close()
    innermost.venv = worlds
    normalization = unwrap_vec_normalize(env)
    if normalization is not None:
        normalization.returns = state["returns"]
    return env
