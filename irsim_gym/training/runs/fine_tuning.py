"""Fine-tuning: runs that start from the weights, networks and normalisation of a policy, with new schedules."""

import hashlib
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

from gymnasium import Space
from gymnasium.spaces import Box
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecNormalize, unwrap_vec_normalize
from torch import Tensor
from torch.nn.functional import pad

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.saved_policies.algorithms import ALGORITHMS
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, form_of, load_policy, policy_file
from irsim_gym.training.settings.algorithm_options import ACTIVATIONS
from irsim_gym.training.settings.run import Settings

SHAPES = (
    *("net_arch", "activation_fn", "features_extractor_kwargs", "share_features_extractor", "full_std"),
    *("n_critics", "n_quantiles", "memory_size"),
)
"""Arguments of a policy that determine the shapes of the weights, or what the networks compute."""


def load_origin(source: str | Path) -> tuple[Path, SavedPolicy]:
    """Load a policy to start from, and return its file and the policy.

    Args:
        source: A run's folder, or a ``policy.zip``.

    Raises:
        IrsimGymError: If there is no such policy, or it has no critic.
    """
    file = policy_file(source)
    loaded = load_policy(file)
    assert isinstance(loaded, SavedPolicy)
    if not isinstance(loaded.model, BaseAlgorithm):
        raise IrsimGymError(f"{file} holds an actor without a critic: --from needs a run or a policy.zip")
    return file, loaded


def _model(policy: SavedPolicy) -> BaseAlgorithm:
    assert isinstance(policy.model, BaseAlgorithm), "what load_origin returned"
    return policy.model


def algorithm_of(policy: SavedPolicy) -> str:
    """Return the name of the algorithm that a policy was trained with."""
    kind = type(_model(policy)).__name__
    return next(name for name, item in ALGORITHMS.items() if item.class_name == kind)


def inherit_settings(settings: Settings, file: Path, policy: SavedPolicy) -> Settings:
    """Return settings with the networks and the normalisation of the policy that they start from.

    Raises:
        IrsimGymError: If the policy was trained with another algorithm, or has custom network classes.
    """
    if algorithm_of(policy) != settings.algorithm:
        raise IrsimGymError(
            f"{file} was trained with {algorithm_of(policy)}, not {settings.algorithm}: --from needs the same algorithm"
        )
    hyper = settings.hyperparameters
    policy_arguments = dict(hyper.arguments.get("policy_kwargs") or {})
    rest = {name: value for name, value in policy_arguments.items() if name not in SHAPES}
    networks = {**rest, **_plain_networks(file, _model(policy).policy_kwargs or {})}
    origin = {"policy": str(file.resolve()), "sha256": hashlib.sha256(file.read_bytes()).hexdigest()}
    normalize = _normalization(policy.normalization, hyper.normalize)
    hyper = replace(hyper, arguments={**hyper.arguments, "policy_kwargs": networks}, normalize=normalize)
    return replace(settings, origin=origin, hyperparameters=hyper)


def _plain_networks(file: Path, networks: Mapping[str, object]) -> dict[str, Any]:
    """Return the arguments that determine the networks, as in a hyper-parameter file."""
    if "features_extractor_class" in networks:
        raise IrsimGymError(f"{file} has a custom features extractor, which --from does not support")
    shapes = {name: networks[name] for name in SHAPES if name in networks}
    if "activation_fn" in shapes:
        called = getattr(shapes["activation_fn"], "__name__", str(shapes["activation_fn"]))
        names = {activation: name for name, activation in ACTIVATIONS.items()}
        if called not in names:
            raise IrsimGymError(f"{file} has the activation function {called}, which --from does not support")
        shapes["activation_fn"] = names[called]
    return shapes


def _normalization(learned: VecNormalize | None, options: Mapping[str, object] | None) -> Mapping[str, Any] | None:
    if learned is None:
        return None
    norms = {"norm_obs": learned.norm_obs, "norm_reward": learned.norm_reward}
    keys = {} if learned.norm_obs_keys is None else {"norm_obs_keys": list(learned.norm_obs_keys)}
    return {**norms, **(options or {}), **keys, "norm_obs": learned.norm_obs}


def _columns(space: Space[Any]) -> int:
    """Return the number of columns of flat observations; 0 for others."""
    return space.shape[0] if isinstance(space, Box) and len(space.shape) == 1 else 0


def _widened(learned: Mapping[str, Tensor], current: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Return weights for more observations: those of the columns that come last are zero, so that actions are equal."""
    lengths = {name: current[name].shape[-1] - item.shape[-1] for name, item in learned.items() if item.ndim == 2}
    return {name: pad(item, (0, lengths[name])) if lengths.get(name, 0) > 0 else item for name, item in learned.items()}


def _misfit(file: Path, what: str, learned: Space[Any], task: Space[Any]) -> IrsimGymError:
    return IrsimGymError(
        f"{file} was trained with {what} {form_of(learned)}, but this task has {form_of(task)}: --from needs the same, "
        "or more observations at the end of a vector without normalisation"
    )


def copy_weights(model: BaseAlgorithm, settings: Settings) -> None:
    """Copy the weights and the normalisation of the policy that a run starts from into its new model.

    Observations that the policy does not know may follow those that it knows: they begin without influence.

    Raises:
        IrsimGymError: If the policy no longer exists, or was trained with other observations or actions.
    """
    assert settings.origin is not None
    file, policy = load_origin(settings.origin["policy"])
    learned = _model(policy)
    weights = learned.policy.state_dict()
    names, before = settings.perception().names, [] if policy.perception is None else policy.perception.names
    more = _columns(learned.observation_space) < _columns(model.observation_space)
    if more and policy.normalization is None and names[: len(before)] == before:
        weights = _widened(weights, model.policy.state_dict())
    elif form_of(learned.observation_space) != form_of(model.observation_space):
        raise _misfit(file, "observations", learned.observation_space, model.observation_space)
    if form_of(learned.action_space) != form_of(model.action_space):
        raise _misfit(file, "actions", learned.action_space, model.action_space)
    try:
        model.policy.load_state_dict(weights)
    except RuntimeError as error:
        raise IrsimGymError(f"the weights of {file} do not fit the networks of this run: {error}") from error
    entropy, begun = getattr(model, "log_ent_coef", None), getattr(learned, "log_ent_coef", None)
    if entropy is not None and begun is not None:
        entropy.data.copy_(begun.data)
    env = model.get_env()
    statistics = None if env is None else unwrap_vec_normalize(env)
    if statistics is not None and policy.normalization is not None:
        statistics.obs_rms = deepcopy(policy.normalization.obs_rms)
        statistics.ret_rms = deepcopy(policy.normalization.ret_rms)
