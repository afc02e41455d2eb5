"""A policy of Stable-Baselines3 as a module of RLlib: it takes dict observations, and has its values on runners."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import torch
from gymnasium.spaces import Dict, Discrete
from ray.rllib.core.columns import Columns
from ray.rllib.core.rl_module.apis import ValueFunctionAPI
from ray.rllib.core.rl_module.torch import TorchRLModule

from irsim_gym.evaluation.saved_policies.policies import channels_first, is_picture


class PolicyModule(TorchRLModule, ValueFunctionAPI):
    """The networks of the policy whose class is ``policy`` in ``model_config``."""

    def setup(self) -> None:
        kind = self.model_config["policy"]
        self.policy = kind(channels_first(self.observation_space), self.action_space, lambda _: 0.0)

    def compute_values(self, batch: Mapping[str, Any], embeddings: Any = None) -> Any:
        return self.policy.predict_values(self._shown(batch[Columns.OBS])).squeeze(-1)

    def _forward(self, batch: Mapping[str, Any], **kwargs: Any) -> dict[str, Any]:
        return {Columns.ACTION_DIST_INPUTS: self._distribution(batch[Columns.OBS])}

    def _distribution(self, seen: Any) -> torch.Tensor:
        policy = self.policy
        features = policy.extract_features(self._shown(seen), policy.pi_features_extractor)
        means = policy.action_net(policy.mlp_extractor.forward_actor(features))
        if isinstance(self.action_space, Discrete):
            return means
        return torch.cat([means, policy.log_std.expand_as(means)], dim=-1)

    def _shown(self, seen: Any) -> Any:
        space = self.observation_space
        if isinstance(space, Dict):
            return {name: _first(seen[name], part) for name, part in space.spaces.items()}
        return _first(seen, space)


def _first(seen: torch.Tensor, space: Any) -> torch.Tensor:
    return seen.permute(0, 3, 1, 2) if is_picture(space) else seen
