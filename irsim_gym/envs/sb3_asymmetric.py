"""An actor-critic of Stable-Baselines3 whose critic sees more than the actor (Pinto et al. 2018)."""

from __future__ import annotations

from typing import Any

from gymnasium import Space
from gymnasium.spaces import Dict
from numpy.typing import NDArray
from stable_baselines3.common.policies import MultiInputActorCriticPolicy
from stable_baselines3.common.torch_layers import MlpExtractor
from stable_baselines3.common.type_aliases import PyTorchObs

from irsim_gym.envs.sb3_critic_parts import actor_parts, lone_name


class AsymmetricPolicy(MultiInputActorCriticPolicy):
    """The policy of PPO and A2C for environments with observations of the critic alone, ``make_vec_env(critic=True)``.

    Networks of the actor read all parts of the observation but ``critic`` and ``critic_NAME``; those of the critic read
    all of it. Actions therefore need no observations of the critic: ``predict`` takes what an environment without them
    gives. It takes the arguments of ``MultiInputPolicy``; actor and critic never share an extractor.

    Args:
        observation_space: What is observed.
        action_space: What is done.
        lr_schedule: Learning rate, without unit, over the share of the run that is left.
        share_features_extractor: Only False.
        **kwargs: More arguments of ``MultiInputPolicy``.

    Raises:
        ValueError: ``share_features_extractor`` is True.
    """

    def __init__(
        self,
        observation_space: Dict,
        action_space: Space[Any],
        lr_schedule: Any,
        *,
        share_features_extractor: bool = False,
        **kwargs: Any,
    ) -> None:
        if share_features_extractor:
            raise ValueError("share_features_extractor must be false: the critic sees more than the actor")
        super().__init__(observation_space, action_space, lr_schedule, share_features_extractor=False, **kwargs)

    def _build_mlp_extractor(self) -> None:
        """Make the extractor of the actor for its part of the observation, and networks for features of both sizes."""
        own = actor_parts(self.observation_space)
        self.features_extractor = self.features_extractor_class(own, **self.features_extractor_kwargs)
        self.pi_features_extractor = self.features_extractor
        shape: dict[str, Any] = {"net_arch": self.net_arch, "activation_fn": self.activation_fn, "device": self.device}
        self.mlp_extractor = MlpExtractor(self.pi_features_extractor.features_dim, **shape)
        critic = MlpExtractor(self.vf_features_extractor.features_dim, **shape)
        self.mlp_extractor.value_net, self.mlp_extractor.latent_dim_vf = critic.value_net, critic.latent_dim_vf

    def obs_to_tensor(self, observation: NDArray[Any] | dict[str, NDArray[Any]]) -> tuple[PyTorchObs, bool]:
        """Return an observation as tensors, and whether there are several; a lone array is that of the actor."""
        given = observation if isinstance(observation, dict) else {lone_name(self.observation_space): observation}
        tensors, several = super().obs_to_tensor(given)
        return tensors, several
