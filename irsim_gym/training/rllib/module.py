"""A policy of Stable-Baselines3 as a module of RLlib, so that its weights fit a ``policy.zip``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from gymnasium import Space
from gymnasium.spaces import Dict, Discrete
from numpy.typing import NDArray
from ray.rllib.core.columns import Columns
from ray.rllib.core.learner.utils import make_target_network
from ray.rllib.core.rl_module.apis import TARGET_NETWORK_ACTION_DIST_INPUTS, TargetNetworkAPI, ValueFunctionAPI
from ray.rllib.core.rl_module.torch import TorchRLModule
from stable_baselines3.common.policies import ActorCriticPolicy

from irsim_gym.evaluation.saved_policies.policies import channels_first, is_picture

PREFIX = "policy."
"""Prefix of the names of the policy's weights in the state of the module."""


class PolicyModule(TorchRLModule, ValueFunctionAPI, TargetNetworkAPI):  # type: ignore[misc]
    """The networks of an actor-critic policy of Stable-Baselines3.

    ``model_config`` contains ``policy``, the class, and its ``arguments``. It may contain ``weights``, the initial
    state as arrays.
    """

    def setup(self) -> None:
        """Make the networks, with the initial weights if given."""
        config = self.model_config
        kind: type[ActorCriticPolicy] = config["policy"]
        seen = channels_first(self.observation_space)
        self.policy = kind(seen, self.action_space, lambda _: 0.0, **config["arguments"])
        if config.get("weights") is not None:
            state = {name: torch.from_numpy(np.array(array)) for name, array in config["weights"].items()}
            self.policy.load_state_dict(state)

    def make_target_networks(self) -> None:
        """Make the target networks, for APPO."""
        self.old_policy = make_target_network(self.policy)

    def get_target_network_pairs(self) -> list[tuple[Any, Any]]:
        """Return the networks with their target networks."""
        return [(self.policy, self.old_policy)]

    def forward_target(self, batch: Mapping[str, Any]) -> dict[str, Any]:
        """Return the inputs of the target networks' action distribution."""
        return {TARGET_NETWORK_ACTION_DIST_INPUTS: self._distribution(self.old_policy, batch[Columns.OBS])}

    def compute_values(self, batch: Mapping[str, Any], embeddings: Any = None) -> Any:
        """Return the values of observations, ``(n,)``."""
        return self.policy.predict_values(self._shown(batch[Columns.OBS])).squeeze(-1)

    def _forward(self, batch: Mapping[str, Any], **kwargs: Any) -> dict[str, Any]:
        return {Columns.ACTION_DIST_INPUTS: self._distribution(self.policy, batch[Columns.OBS])}

    def _distribution(self, policy: ActorCriticPolicy, seen: Any) -> torch.Tensor:
        """Return the concatenated means and log standard deviations; for discrete actions, the logits."""
        features: Any = policy.extract_features(self._shown(seen), policy.pi_features_extractor)
        means: torch.Tensor = policy.action_net(policy.mlp_extractor.forward_actor(features))
        if isinstance(self.action_space, Discrete):
            return means
        return torch.cat([means, policy.log_std.expand_as(means)], dim=-1)

    def _shown(self, seen: Any) -> Any:
        """Return observations with the channels of images first."""
        space = self.observation_space
        if isinstance(space, Dict):
            return {name: _first(seen[name], part) for name, part in space.spaces.items()}
        return _first(seen, space)


def module_state(state: Mapping[str, Any]) -> dict[str, torch.Tensor]:
    """Return the state of the Stable-Baselines3 policy in a module's state."""
    own = {name.removeprefix(PREFIX): array for name, array in state.items() if name.startswith(PREFIX)}
    return {name: torch.from_numpy(np.array(array)) for name, array in own.items()}


def policy_state(policy: ActorCriticPolicy) -> dict[str, NDArray[Any]]:
    """Return the state of a policy as arrays."""
    return {name: tensor.detach().cpu().numpy().copy() for name, tensor in policy.state_dict().items()}


def _first(seen: torch.Tensor, space: Space[Any]) -> torch.Tensor:
    return seen.permute(0, 3, 1, 2) if is_picture(space) else seen
