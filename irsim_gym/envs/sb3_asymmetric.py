"""An actor-critic of Stable-Baselines3 whose critic sees more than the actor (Pinto et al. 2018)."""

from __future__ import annotations

from typing import Any

from gymnasium import Space
from gymnasium.spaces import Dict
from numpy.typing import NDArray
from stable_baselines3.common.policies import MultiInputActorCriticPolicy
from stable_baselines3.common.torch_layers import MlpExtractor
from stable_baselines3.common.type_aliases import PyTorchObs
from stable_baselines3.common.vec_env import VecNormalize

from irsim_gym.tasks.transition import CRITIC


class AsymmetricPolicy(MultiInputActorCriticPolicy):
    """The policy of PPO and A2C for environments with observations of the critic alone, ``make_vec_env(critic=True)``.

    Networks of the actor read all parts of the observation but ``critic`` and ``critic_NAME``; those of the critic read
    all of it. Actions therefore need no observations of the critic: ``predict`` takes what an environment without them
    gives. It takes the arguments of ``MultiInputPolicy``; actor and critic never share an extractor.
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


def has_critic_parts(space: Space[Any]) -> bool:
    """Return whether observations have parts that the critic alone sees."""
    return isinstance(space, Dict) and any(_is_critics(name) for name in space.spaces)


def actor_parts(space: Space[Any]) -> Dict:
    """Return the parts of a space of observations that an actor sees."""
    assert isinstance(space, Dict), "with observations of the critic alone there are several parts"
    return Dict({name: part for name, part in space.spaces.items() if not _is_critics(name)})


def actor_observation_space(space: Space[Any]) -> Space[Any]:
    """Return the space of what an actor observes where nobody tells the critic more; others as they are."""
    if not has_critic_parts(space):
        return space
    own = actor_parts(space)
    return next(iter(own.spaces.values())) if len(own.spaces) == 1 else own


def lone_name(space: Space[Any]) -> str:
    """Return the name of the only part that an actor sees.

    Raises:
        ValueError: It sees several.
    """
    names = list(actor_parts(space).spaces)
    if len(names) != 1:
        raise ValueError(f"the actor observes {', '.join(names)}: pass a dict of these")
    return names[0]


def for_actor(normalization: VecNormalize | None) -> VecNormalize | None:
    """Let a ``VecNormalize`` normalise what an actor observes, and not look for more. It can learn no more then."""
    if normalization is not None and has_critic_parts(normalization.observation_space):
        own = actor_parts(normalization.observation_space).spaces
        normalization.norm_obs_keys = [name for name in normalization.norm_obs_keys or () if name in own]
    return normalization


def _is_critics(name: str) -> bool:
    return name == CRITIC or name.startswith(f"{CRITIC}_")
