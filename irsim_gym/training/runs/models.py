"""Models of Stable-Baselines3 for a run: new ones, and those restored from checkpoints."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium import Space
from gymnasium.spaces import Dict
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.noise import NormalActionNoise
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.preprocessing import is_image_space
from stable_baselines3.common.vec_env import VecEnv

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.outside_files import reading
from irsim_gym.envs.sb3_learning.mirror import checked_mirror
from irsim_gym.evaluation.saved_policies import checkpoint_files as stored
from irsim_gym.evaluation.saved_policies.algorithms import find_algorithm
from irsim_gym.training.runs import checkpoint as files
from irsim_gym.training.runs.environment import build_environment, restore_worlds
from irsim_gym.training.settings.run import Run, Settings


def algorithm_class(settings: Settings) -> type[BaseAlgorithm]:
    """Return the class of a run's algorithm; for a team, the class that masks waiting robots.

    Raises:
        IrsimGymError: If there is no such algorithm, or it is not installed.
    """
    return find_algorithm(settings.algorithm).load(settings.is_team)


def resolve_device(device: str) -> str:
    """Return a device of PyTorch, with ``auto`` resolved.

    Raises:
        IrsimGymError: If the device is unknown or not available.
    """
    if device == "auto":
        return "cuda" if torch.cuda.is_available() else "cpu"
    kind, _, number = device.partition(":")
    there = {"cpu": True, "cuda": torch.cuda.is_available(), "mps": torch.backends.mps.is_available()}
    if kind not in there:
        raise IrsimGymError(f"device must be auto, cpu, cuda, cuda:1 (and so on) or mps, got '{device}'")
    if not there[kind]:
        raise IrsimGymError(f"device {device}: PyTorch {torch.__version__} finds none here; use cpu or auto")
    if kind == "cuda" and number and not int(number) < torch.cuda.device_count():
        raise IrsimGymError(f"device {device}: there are cuda:0 to cuda:{torch.cuda.device_count() - 1} here")
    return device


def network_kind(space: Space[Any]) -> str:
    """Return the kind of network of Stable-Baselines3 for an observation space: MultiInput, Cnn or Mlp."""
    if isinstance(space, Dict):
        return "MultiInput"
    return "Cnn" if is_image_space(space) else "Mlp"


def dict_policy_arguments(policy: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of a policy for dict observations, where ``features_dim`` is named ``cnn_output_dim``."""
    arguments = dict(policy.get("features_extractor_kwargs") or {})
    if "features_dim" not in arguments or "features_extractor_class" in policy:
        return dict(policy)
    arguments["cnn_output_dim"] = arguments.pop("features_dim")
    return {**policy, "features_extractor_kwargs": arguments}


def new_model(settings: Settings) -> BaseAlgorithm:
    """Make a model with random weights, and the environment of the run.

    Raises:
        IrsimGymError: If the algorithm, its hyper-parameters or the device cannot be used.
    """
    kind = algorithm_class(settings)
    device = resolve_device(settings.hyperparameters.device)
    arguments = settings.hyperparameters.algorithm_arguments()
    env = build_environment(settings)
    suffix = find_algorithm(settings.algorithm).policy_suffix
    policy: Any = f"{network_kind(env.observation_space)}{suffix}Policy"
    if network_kind(env.observation_space) == "MultiInput":
        arguments["policy_kwargs"] = dict_policy_arguments(arguments["policy_kwargs"])
    if arguments.get("action_noise") is not None:
        arguments["action_noise"] = _noise(env, arguments["action_noise"])
    try:
        model = kind(arguments.pop("policy", policy), env, seed=settings.seed, device=device, **arguments)
    except (TypeError, ValueError, AssertionError, KeyError) as error:
        env.close()
        why = str(error).replace(str(env.observation_space), "these observations")  # else all their bounds
        raise IrsimGymError(f"{settings.algorithm} does not take these hyper-parameters: {why}") from error
    _check_mirror(model, settings)
    env.seed(settings.first_level)
    return model


def _check_mirror(model: BaseAlgorithm, settings: Settings) -> None:
    """Check that a run can learn from mirrored rows, if it is to."""
    if not settings.hyperparameters.mirror:
        return
    try:
        checked_mirror(model)
    except IrsimGymError as error:
        env = model.get_env()
        assert env is not None
        env.close()
        raise IrsimGymError(f"mirror: {error}") from error


def _noise(env: VecEnv, deviation: float) -> NormalActionNoise:
    """Return independent Gaussian noise for each component of the action."""
    size = env.action_space.shape
    assert size is not None
    return NormalActionNoise(np.zeros(size, np.float32), np.full(size, deviation, np.float32))


def check_finite(run: Run, settings: Settings, model: BaseAlgorithm) -> None:
    """Check that the weights of the networks are finite, and the standard deviations of actions finite and positive.

    Raises:
        IrsimGymError: They are not. The message names the newest checkpoint, whose numbers are.
    """
    logarithms = [tensor for name, tensor in model.policy.named_parameters() if name == "log_std"]
    deviations = [part for tensor in logarithms for part in (tensor.exp(), (-tensor).exp())]
    if all(bool(torch.isfinite(tensor).all()) for tensor in (*model.policy.parameters(), *deviations)):
        return
    newest = stored.newest_checkpoint(run.checkpoints)
    rate = settings.hyperparameters.arguments.get("learning_rate")
    advice = f"the newest checkpoint is kept, --from {newest} starts there" if newest else "there is no checkpoint yet"
    raise IrsimGymError(
        f"the training has diverged after {model.num_timesteps:,} steps, its networks are not finite: take a smaller "
        f"learning_rate (it was {rate}) or max_grad_norm; {advice}"
    )


def restored_model(settings: Settings, newest: Path) -> tuple[BaseAlgorithm, stored.RunProgress]:
    """Return the model of a checkpoint, with its worlds within their episodes, and the progress of the run.

    Raises:
        UnreadableFileError: If a file of the checkpoint is damaged, or another version has written it.
    """
    state, progress = files.load_state(newest), stored.load_progress(newest)
    normalization = newest / stored.NORMALIZATION
    device = resolve_device(settings.hyperparameters.device)
    with reading(normalization, "file of statistics of VecNormalize"):
        env = build_environment(settings, normalization if normalization.is_file() else None)
    with reading(newest / stored.STATE, "state that this version can resume"):
        env = restore_worlds(env, state["worlds"])
    kind: Any = algorithm_class(settings)
    with reading(newest / stored.POLICY, "policy of Stable-Baselines3"):
        model: BaseAlgorithm = kind.load(newest / stored.POLICY, env=env, device=device, force_reset=False)
    if isinstance(model, OffPolicyAlgorithm):
        with reading(newest / stored.REPLAY_BUFFER, "replay buffer"):
            model.load_replay_buffer(newest / stored.REPLAY_BUFFER, truncate_last_traj=False)
    _check_mirror(model, settings)
    with reading(newest / stored.STATE, "state that this version can resume"):
        files.restore_memories(model, state)
        files.restore_random(model, state)
    return model, progress
