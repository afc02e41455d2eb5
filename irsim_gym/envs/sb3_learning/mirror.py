"""Learning from mirrored rows as a callback of Stable-Baselines3."""

from dataclasses import asdict
from typing import Any

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict, Discrete
from gymnasium.utils.env_checker import data_equivalence
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv, VecTransposeImage, is_vecenv_wrapped, unwrap_vec_normalize

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.parts.mirror import Mirror
from irsim_gym.envs.parts.observations import on_each
from irsim_gym.envs.sb3_learning.gru import GruPPO


class MirrorCallback(BaseCallback):
    """Lets PPO learn from each rollout with left and right exchanged in a random part of its rows.

    ``model.learn(100_000, callback=MirrorCallback())`` goes with ``PPO`` and ``MaskedPPO``, and with all environments
    of this package. Mirrored rows keep the densities with which their actions were drawn, so that they are weighted as
    experience of another policy (Abdolhosseini et al. 2019, "On learning symmetric locomotion", compare ways to do
    this). ``train/approx_kl`` and ``train/clip_fraction`` count them too. Do not use it in worlds where left and right
    differ, for example where people keep to the right.

    Args:
        share: Share of the rows that are mirrored.
        seed: Seed of the choice of rows.

    Raises:
        ValueError: If ``share`` is not from 0 to 1, or ``seed`` is negative.
    """

    def __init__(self, *, share: float = 0.5, seed: int = 0) -> None:
        super().__init__()
        if not 0.0 <= share <= 1.0:
            raise ValueError(f"share must be from 0 to 1, got {share!r}")
        if seed < 0:
            raise ValueError(f"seed must be >= 0, got {seed!r}")
        self.share = share
        self.seed = seed
        self._mirror: Mirror | None = None
        self._channels_first = False

    def _on_training_start(self) -> None:
        self._mirror = checked_mirror(self.model)
        self._channels_first = is_vecenv_wrapped(self.training_env, VecTransposeImage)

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        """Mirror rows of the rollout. The choice depends on the seed and the number of steps alone."""
        assert self._mirror is not None, "it is made when the training starts"
        buffer: Any = self.model.rollout_buffer  # type: ignore[attr-defined]
        chosen = np.random.default_rng((self.seed, self.num_timesteps)).random(buffer.rewards.shape) < self.share
        seen = buffer.observations
        picked = on_each(seen, lambda part: part[chosen])
        mirrored = self._mirror.observation(picked, channels_first=self._channels_first)
        if isinstance(mirrored, dict):
            for key, part in mirrored.items():
                seen[key][chosen] = part
        else:
            seen[chosen] = mirrored
        buffer.actions[chosen] = self._mirror.actions(buffer.actions[chosen])


def checked_mirror(model: Any) -> Mirror:
    """Return the mirror of the environment of an algorithm that can learn from mirrored rows.

    Raises:
        IrsimGymError: If it cannot; the message says why.
    """
    if not isinstance(model, PPO) or isinstance(model, GruPPO):
        raise IrsimGymError(f"only PPO without memory can learn from mirrored rows; got {type(model).__name__}")
    if model.clip_range_vf is not None:
        raise IrsimGymError("clip_range_vf would compare mirrored rows with values of rows as they were: leave it out")
    if model.target_kl is not None:
        raise IrsimGymError("target_kl would stop updates early, because of mirrored rows: leave it out")
    env = model.get_env()
    assert env is not None
    normalized = unwrap_vec_normalize(env)
    if normalized is not None and normalized.norm_obs:
        raise IrsimGymError("observations that VecNormalize normalises cannot be mirrored: normalise rewards alone")
    mirror, is_first = common_mirror(env), is_vecenv_wrapped(env, VecTransposeImage)
    if not _fits_observations(mirror, env.observation_space, channels_first=is_first):
        raise IrsimGymError("a wrapper changes parts, shapes or bounds of observations, so they cannot be mirrored")
    if not _fits_actions(mirror, env.action_space):
        raise IrsimGymError("a wrapper changes the space of actions, so they cannot be mirrored")
    return mirror


def _fits_observations(mirror: Mirror, space: Space[Any], *, channels_first: bool) -> bool:
    """Return whether observations of a space have the arrays of a mirror, within the bounds of those of our tasks."""
    parts = space.spaces if isinstance(space, Dict) else {"": space}
    if parts.keys() != {*mirror.vectors, *mirror.images}:
        return False
    for key, part in parts.items():
        shape, is_image = part.shape or (), key in mirror.images
        if is_image and (len(shape) != 3 or shape[-1 if channels_first else -2] != len(mirror.images[key])):
            return False
        if not is_image and shape != mirror.vectors[key].columns.shape:
            return False
        if not is_image and not (isinstance(part, Box) and np.abs([part.low, part.high]).max(initial=0.0) <= 1.0):
            return False
    return True


def _fits_actions(mirror: Mirror, space: Space[Any]) -> bool:
    if mirror.choices.size:
        return isinstance(space, Discrete) and space.n == mirror.choices.size
    if not isinstance(space, Box) or space.shape != mirror.action.columns.shape:
        return False
    return bool((space.low == -1.0).all() and (space.high == 1.0).all())


def common_mirror(env: VecEnv) -> Mirror:
    """Return the mirror of all slots of an environment.

    Raises:
        IrsimGymError: If it is no environment of this package, has no mirror, or its slots have several.
    """
    try:
        if not env.has_attr("mirror"):
            raise IrsimGymError(f"mirrored rows need an environment of irsim_gym, got {env.unwrapped}")
        mirrors: list[Mirror] = env.env_method("mirror")
    except (EOFError, ConnectionError) as error:
        raise IrsimGymError("a worker ended when asked for its mirror: mirror() of one environment says why") from error
    first = asdict(mirrors[0])
    if not all(mirror is mirrors[0] or data_equivalence(asdict(mirror), first, exact=True) for mirror in mirrors):
        raise IrsimGymError("mirrored rows need slots that observe and act alike")
    return mirrors[0]
