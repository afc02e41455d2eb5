"""The check that the engine of a run supports its settings."""

from typing import Any

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.saved_policies.algorithms import find_algorithm
from irsim_gym.training.settings.run import Settings

PPO_KEYS = ("batch_size", "n_epochs", "gae_lambda")
KEYS = ("n_steps", "learning_rate", "gamma", "ent_coef", "vf_coef", "max_grad_norm", "clip_range", "policy_kwargs")
"""Hyper-parameters that are passed to RLlib. PPO also takes ``PPO_KEYS``."""


def check_engine(settings: Settings) -> None:
    """Check that the engine of a run supports its settings.

    Raises:
        IrsimGymError: If it does not support the algorithm, a hyper-parameter, a mixture or the device.
    """
    needed = find_algorithm(settings.algorithm).engine
    if settings.engine is None:
        if needed:
            raise IrsimGymError(f"{settings.algorithm} is an algorithm of RLlib: add --engine {needed}")
        return
    if settings.algorithm not in ("ppo", "appo"):
        raise IrsimGymError(f"--engine rllib trains ppo and appo, not {settings.algorithm}")
    if settings.mixture:
        raise IrsimGymError("--engine rllib trains in one scenario, not in a mixture: leave out --mixture or --engine")
    wanted = settings.hyperparameters
    known = {*KEYS, *(PPO_KEYS if settings.algorithm == "ppo" else ())}
    unknown = [name for name, value in wanted.arguments.items() if name not in known and value is not None]
    own: dict[str, Any] = {
        "normalize": wanted.normalize,
        "mirror": wanted.mirror or None,
        "clone": wanted.clone,
        "until": wanted.until,
    }
    unknown += [name for name, value in own.items() if value is not None]
    if unknown:
        raise IrsimGymError(
            f"--engine rllib cannot pass on {', '.join(unknown)} to {settings.algorithm}; it takes "
            f"{', '.join(sorted(known))}: leave out the others, or set them to null"
        )
    if wanted.device not in ("cpu", "auto"):
        raise IrsimGymError(f"device {wanted.device}: with --engine rllib, --learner-gpus says where it learns")
    if callable(wanted.algorithm_arguments().get("clip_range")):
        raise IrsimGymError("clip_range must be a number with --engine rllib: RLlib knows no schedule of it")
