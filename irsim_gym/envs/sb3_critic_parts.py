"""Which parts of an observation the critic alone sees, and what is left for the actor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gymnasium import Space
from gymnasium.spaces import Dict

from irsim_gym.tasks.transition import CRITIC

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecNormalize


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
    """Let a ``VecNormalize``, or None, normalise what an actor observes and no more. It can learn no more then."""
    if normalization is not None and has_critic_parts(normalization.observation_space):
        own = actor_parts(normalization.observation_space).spaces
        normalization.norm_obs_keys = [name for name in normalization.norm_obs_keys or () if name in own]
    return normalization


def _is_critics(name: str) -> bool:
    return name == CRITIC or name.startswith(f"{CRITIC}_")
