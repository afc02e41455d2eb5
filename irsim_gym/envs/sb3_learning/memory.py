"""An actor-critic policy of Stable-Baselines3 with a memory, a GRU (Cho et al. 2014)."""

from typing import Any, NamedTuple

import numpy as np
import torch
from gymnasium import Space
from gymnasium.spaces import Box, Dict
from numpy.typing import NDArray
from stable_baselines3.common import torch_layers as layers
from stable_baselines3.common.distributions import Distribution
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.preprocessing import is_image_space
from stable_baselines3.common.type_aliases import PyTorchObs
from torch import nn
from torch.nn.utils.rnn import PackedSequence

MEMORY_SIZE = 64


class Sequences(NamedTuple):
    """Observations of several sequences in the order of ``PackedSequence``: by step, longer sequences first.

    Attributes:
        observations: A row for each step of each sequence, shape ``(n_rows, ...)``.
        running: Number of sequences that have not ended at each step, shape ``(longest,)``; it never increases.
        memory: Memory before each sequence, shape ``(1, n_sequences, memory_size)``.
    """

    observations: PyTorchObs
    running: torch.Tensor
    memory: torch.Tensor


class GruPolicy(ActorCriticPolicy):
    """The actor and the critic receive the features of the observation and the output of a GRU.

    The input of the GRU is the features of the actor. A memory has the shape ``(1, n, memory_size)`` and is 0 where an
    episode begins.

    Args:
        observation_space: Space of observations.
        action_space: Space of actions.
        lr_schedule: Learning rate, without unit, over the share of the run that is left.
        memory_size: Length of the memory.
        **kwargs: More arguments of ``ActorCriticPolicy``.

    Raises:
        ValueError: If ``use_sde`` is True.
    """

    def __init__(
        self,
        observation_space: Space[Any],
        action_space: Space[Any],
        lr_schedule: Any,
        *,
        memory_size: int = MEMORY_SIZE,
        **kwargs: Any,
    ) -> None:
        if kwargs.get("use_sde"):
            raise ValueError("use_sde does not go with a memory")
        self.memory_size = memory_size
        kwargs.setdefault("features_extractor_class", _extractor_for(observation_space))
        super().__init__(observation_space, action_space, lr_schedule, **kwargs)

    @property
    def memory_shape(self) -> tuple[int, int, int]:
        """Number of arrays in a state, number of layers, and size of each."""
        return 1, 1, self.memory_size

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return {**super()._get_constructor_parameters(), "memory_size": self.memory_size}

    def _build_mlp_extractor(self) -> None:
        n_seen = self.pi_features_extractor.features_dim
        self.memory = nn.GRU(n_seen, self.memory_size)
        if self.ortho_init:
            for name, weight in self.memory.named_parameters():
                if name.startswith("weight"):
                    nn.init.orthogonal_(weight)
        shape: dict[str, Any] = {"net_arch": self.net_arch, "activation_fn": self.activation_fn, "device": self.device}
        self.mlp_extractor = layers.MlpExtractor(n_seen + self.memory_size, **shape)
        # A second one, although one holds both networks: a seed shall give the weights that it has always given.
        critic = layers.MlpExtractor(self.vf_features_extractor.features_dim + self.memory_size, **shape)
        self.mlp_extractor.value_net, self.mlp_extractor.latent_dim_vf = critic.value_net, critic.latent_dim_vf

    def first_memory(self, n: int) -> torch.Tensor:
        """Return the memory at the beginning of ``n`` episodes, shape ``(1, n, memory_size)``."""
        return torch.zeros(1, n, self.memory_size, device=self.device)

    def forward(  # type: ignore[override]
        self, obs: PyTorchObs, memory: torch.Tensor, starts: torch.Tensor, deterministic: bool = False
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return actions, values, log-probabilities, and the memory after this step.

        Args:
            obs: Observations, ``(n, ...)``.
            memory: The memory before this step.
            starts: 1 where an episode begins, else 0, ``(n,)``.
            deterministic: Whether to return the most probable action.
        """
        seen = self._seen(obs)
        recalled, memory = self._remember(seen, memory, starts)
        distribution = self._distribution(seen, recalled)
        actions = distribution.get_actions(deterministic=deterministic)
        values = self._values(obs, seen, recalled)
        shape = self.action_space.shape or ()
        return actions.reshape(-1, *shape), values, distribution.log_prob(actions), memory

    def evaluate_actions(  # type: ignore[override]
        self, obs: Sequences, actions: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor | None]:
        """Return values, log-probabilities and entropies of the actions in sequences, in the order of the rows."""
        seen = self._seen(obs.observations)
        recalled = self.memory(PackedSequence(seen, obs.running), obs.memory)[0].data
        distribution = self._distribution(seen, recalled)
        values = self._values(obs.observations, seen, recalled)
        return values, distribution.log_prob(actions), distribution.entropy()

    def predict_values(  # type: ignore[override]
        self, obs: PyTorchObs, memory: torch.Tensor, starts: torch.Tensor
    ) -> torch.Tensor:
        """Return the values of observations, shape ``(n, 1)``; see ``forward`` for the arguments."""
        seen = self._seen(obs)
        return self._values(obs, seen, self._remember(seen, memory, starts)[0])

    def predict(
        self,
        observation: NDArray[Any] | dict[str, NDArray[Any]],
        state: tuple[NDArray[Any], ...] | None = None,
        episode_start: NDArray[Any] | None = None,
        deterministic: bool = False,
    ) -> tuple[NDArray[Any], tuple[NDArray[Any], ...] | None]:
        """Return actions and the state after them, as policies of Stable-Baselines3 do.

        Args:
            observation: One observation, or several along the first axis.
            state: State that the previous call returned; None at the beginning.
            episode_start: Whether an episode begins, so that its memory is reset; None if none begins.
            deterministic: Whether to return the most probable action.
        """
        self.set_training_mode(False)
        tensors, several = self.obs_to_tensor(observation)
        n = len(next(iter(tensors.values())) if isinstance(tensors, dict) else tensors)
        begins = np.zeros(n) + (0.0 if episode_start is None else np.asarray(episode_start, np.float64))
        memory = self.first_memory(n) if state is None else torch.as_tensor(state[0], device=self.device)
        with torch.no_grad():
            seen = self._seen(tensors)
            starts = torch.as_tensor(begins, dtype=torch.float32, device=self.device)
            recalled, memory = self._remember(seen, memory, starts)
            chosen = self._distribution(seen, recalled).get_actions(deterministic=deterministic)
        actions: NDArray[Any] = chosen.cpu().numpy().reshape(-1, *(self.action_space.shape or ()))
        if isinstance(self.action_space, Box):
            actions = np.clip(actions, self.action_space.low, self.action_space.high)
        return (actions if several else actions[0]), (memory.cpu().numpy(),)

    def _seen(self, obs: PyTorchObs) -> torch.Tensor:
        return self._features(obs, self.pi_features_extractor)

    def _features(self, obs: PyTorchObs, extractor: layers.BaseFeaturesExtractor) -> torch.Tensor:
        features: torch.Tensor = super(ActorCriticPolicy, self).extract_features(obs, extractor)
        return features

    def _remember(
        self, seen: torch.Tensor, memory: torch.Tensor, starts: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        recalled, after = self.memory(seen[None], memory * (1.0 - starts)[None, :, None])
        return recalled[0], after

    def _distribution(self, seen: torch.Tensor, recalled: torch.Tensor) -> Distribution:
        latent = self.mlp_extractor.forward_actor(torch.cat([seen, recalled], dim=1))
        return self._get_action_dist_from_latent(latent)

    def _values(self, obs: PyTorchObs, seen: torch.Tensor, recalled: torch.Tensor) -> torch.Tensor:
        shown = seen if self.share_features_extractor else self._features(obs, self.vf_features_extractor)
        values: torch.Tensor = self.value_net(self.mlp_extractor.forward_critic(torch.cat([shown, recalled], dim=1)))
        return values


def _extractor_for(space: Space[Any]) -> type[layers.BaseFeaturesExtractor]:
    if isinstance(space, Dict):
        return layers.CombinedExtractor
    return layers.NatureCNN if is_image_space(space) else layers.FlattenExtractor
