"""Export of the network of a Stable-Baselines3 model as plain data, which runs without PyTorch."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.preprocessing import is_image_space
from stable_baselines3.common.torch_layers import CombinedExtractor, FlattenExtractor, NatureCNN
from stable_baselines3.common.vec_env import VecNormalize
from torch import nn

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.sb3_learning.memory import GruPolicy
from irsim_gym.evaluation.saved_policies.array_network import Options
from irsim_gym.evaluation.saved_policies.shelf import LONE, spaces_of

Step = tuple[Options, dict[str, NDArray[Any]]]


@dataclass(frozen=True)
class ExportedNetwork:
    """A network as plain data.

    Attributes:
        form: Spaces and steps, as JSON data.
        arrays: Arrays by name, as ``ShelfPolicy`` reads them.
        layers: Description of the steps, a line for each part.
    """

    form: dict[str, Any]
    arrays: dict[str, NDArray[Any]]
    layers: tuple[str, ...]

    @property
    def weights(self) -> int:
        """Number of weights."""
        names = [name for name in self.arrays if name.rpartition("/")[2].startswith(("weight", "bias"))]
        return sum(self.arrays[name].size for name in names)


@dataclass
class _Writer:
    """Collects the data of a network. Its methods store arrays, and return the JSON data that belongs to them."""

    form: dict[str, Any]
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)

    def steps(self, place: str, steps: Sequence[Step]) -> list[Options]:
        for i, (_, arrays) in enumerate(steps):
            self.arrays |= {f"{place}/{i}/{name}": array for name, array in arrays.items()}
        return [options for options, _ in steps]

    def box(self, place: str, space: Box) -> str:
        self.arrays |= {f"{place}/low": space.low, f"{place}/high": space.high}
        return str(space.dtype)


class UnfitNetworkError(IrsimGymError):
    """Raised for networks that cannot be written as steps of ``array_network``."""


def export_network(model: BaseAlgorithm, normalization: VecNormalize | None) -> ExportedNetwork:
    """Return the actor of a model as plain data, with the normalisation of its observations.

    Args:
        model: A model of PPO, A2C, SAC, TD3, TQC, DQN or gru_ppo with the networks of its library.
        normalization: Statistics of the observations in the training; None for none.

    Raises:
        UnfitNetworkError: If the network has an LSTM, or modules that are not supported.
    """
    extractor, trunk, output = _actor(model)
    parts = dict(_parts(model, extractor, normalization))
    action = model.action_space
    writer = _Writer({"observation": {}, "parts": {}, "output": output})
    for name, steps in parts.items():
        space = spaces_of(model.observation_space)[name]
        writer.form["observation"][name] = writer.box(f"observation/{name}", space)
        writer.form["parts"][name] = writer.steps(f"part/{name}", steps)
    if isinstance(model.policy, GruPolicy):
        writer.form |= {"memory": {"kind": "gru", "size": model.policy.memory_size}}
        writer.steps("memory", [_gru(model.policy)])
    writer.form["trunk"] = writer.steps("trunk", trunk)
    if isinstance(action, Discrete):
        writer.form["action"] = {"n": int(action.n)}
    else:
        assert isinstance(action, Box)
        writer.form["action"] = {"dtype": writer.box("action", action)}
    lines = [*((name or "observation", steps) for name, steps in parts.items())]
    if isinstance(model.policy, GruPolicy):
        lines.append(("memory", [_gru(model.policy)]))
    lines.append(("action", trunk))
    return ExportedNetwork(writer.form, writer.arrays, tuple(_words(name, steps) for name, steps in lines))


def _actor(model: BaseAlgorithm) -> tuple[nn.Module, list[Step], str]:
    """Return the features extractor of the actor, the steps after it, and how their output becomes an action."""
    policy: Any = model.policy
    if hasattr(policy, "q_net"):
        return policy.q_net.features_extractor, list(_steps(policy.q_net.q_net)), "argmax"
    actor = getattr(policy, "actor", None)
    if actor is not None:  # SAC and TQC have mu after latent_pi. The mu of TD3 includes the final tanh.
        if hasattr(actor, "latent_pi"):
            return actor.features_extractor, [*_steps(actor.latent_pi), *_steps(actor.mu)], "squash"
        *before, last = actor.mu
        if not isinstance(last, nn.Tanh):
            raise UnfitNetworkError(f"the network of {type(policy).__name__} does not end with Tanh")
        return actor.features_extractor, [step for one in before for step in _steps(one)], "squash"
    if not hasattr(policy, "mlp_extractor") or getattr(policy, "squash_output", False):
        raise UnfitNetworkError(f"networks of {type(policy).__name__} cannot be exported")
    layers = [*_steps(policy.mlp_extractor.policy_net), *_steps(policy.action_net)]
    return policy.pi_features_extractor, layers, "argmax" if isinstance(model.action_space, Discrete) else "clip"


def _parts(
    model: BaseAlgorithm, extractor: nn.Module, normalization: VecNormalize | None
) -> Iterator[tuple[str, list[Step]]]:
    """Yield each part of the observation, with the steps that extract its features."""
    if isinstance(extractor, CombinedExtractor):
        each: Mapping[str, nn.Module] = dict(extractor.extractors.items())
    else:
        each = {LONE: extractor}
    for name, module in each.items():
        space = spaces_of(model.observation_space)[name]
        if not isinstance(space, Box):
            raise UnfitNetworkError(f"observations {space} cannot be exported")
        steps = _normalized(name, space, normalization)
        if model.policy.normalize_images and is_image_space(space):
            steps.append(({"kind": "pixels"}, {}))
        yield name, [*steps, *_steps(module)]


def _normalized(name: str, space: Box, normalization: VecNormalize | None) -> list[Step]:
    if normalization is None or not normalization.norm_obs:
        return []
    statistics: Any = normalization.obs_rms
    if name != LONE:
        if name not in (normalization.norm_obs_keys or ()):
            return []
        statistics = statistics[name]
    if is_image_space(space):
        raise UnfitNetworkError("pictures that VecNormalize has normalised cannot be exported")
    options = {"kind": "standardize", "epsilon": normalization.epsilon, "clip": normalization.clip_obs}
    return [(options, {"mean": statistics.mean, "var": statistics.var})]


def _steps(module: nn.Module) -> Iterator[Step]:
    """Yield the steps of a module in order.

    Raises:
        UnfitNetworkError: If the module is of a kind that is not supported.
    """
    if isinstance(module, nn.Sequential):
        for part in module:
            yield from _steps(part)
    elif isinstance(module, NatureCNN):
        yield from _steps(module.cnn)
        yield from _steps(module.linear)
    elif isinstance(module, FlattenExtractor | nn.Flatten):
        yield {"kind": "flatten"}, {}
    elif isinstance(module, nn.Linear):
        yield {"kind": "linear"}, _weights(module)
    elif isinstance(module, nn.Conv2d):
        if (module.padding, module.dilation, module.groups) != ((0, 0), (1, 1), 1):
            raise UnfitNetworkError(f"{module} cannot be exported: no padding, dilation or groups")
        yield {"kind": "convolution", "stride": list(module.stride)}, _weights(module)
    elif type(module) in ACTIVATIONS:
        yield ACTIVATIONS[type(module)](module), {}
    elif not isinstance(module, nn.Identity):
        raise UnfitNetworkError(f"{type(module).__name__} cannot be exported")


ACTIVATIONS: dict[type[nn.Module], Callable[[Any], Options]] = {
    nn.ReLU: lambda module: {"kind": "relu"},
    nn.Tanh: lambda module: {"kind": "tanh"},
    nn.Sigmoid: lambda module: {"kind": "sigmoid"},
    nn.SiLU: lambda module: {"kind": "silu"},
    nn.GELU: lambda module: {"kind": "gelu"},
    nn.ELU: lambda module: {"kind": "elu", "alpha": module.alpha},
    nn.LeakyReLU: lambda module: {"kind": "leaky_relu", "slope": module.negative_slope},
}
"""Modules of activation functions, and the options of their steps."""


def _weights(module: nn.Linear | nn.Conv2d) -> dict[str, NDArray[Any]]:
    weight: NDArray[Any] = module.weight.detach().cpu().numpy()
    bias = np.zeros(len(weight), weight.dtype) if module.bias is None else module.bias.detach().cpu().numpy()
    return {"weight": weight, "bias": bias}


def _gru(policy: GruPolicy) -> Step:
    arrays = {name.removesuffix("_l0"): part.detach().cpu().numpy() for name, part in policy.memory.named_parameters()}
    return {"kind": f"gru {policy.memory_size}"}, arrays


def _words(name: str, steps: Sequence[Step]) -> str:
    """Return a description of steps: ``action: 64, relu, 64, relu, 2``."""
    words = [_word(options, arrays) for options, arrays in steps if options["kind"] != "flatten"]
    return f"{name}: {', '.join(words) or 'as it is'}"


def _word(options: Options, arrays: Mapping[str, NDArray[Any]]) -> str:
    if options["kind"] == "linear":
        return str(len(arrays["bias"]))
    if options["kind"] == "convolution":
        n_filters, _, height, width = arrays["weight"].shape
        return f"{n_filters} filters {height} x {width}"
    return str(options["kind"])
