"""Learning from mirrored rows as a callback of Stable-Baselines3."""

from __future__ import annotations

from typing import Any

import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv, VecTransposeImage, is_vecenv_wrapped, unwrap_vec_normalize

from irsim_gym.envs.mirror import Mirror
from irsim_gym.envs.sb3_gru import GruPPO
from irsim_gym.errors import IrsimGymError


class MirrorCallback(BaseCallback):
    """Lets PPO learn a random part of each rollout as if left and right were exchanged.

    ``model.learn(100_000, callback=MirrorCallback())`` goes with ``PPO`` and ``MaskedPPO``, and with all environments
    of this package. Mirrored rows keep the densities with which their actions were drawn, so that they are weighted as
    experience of another policy (Abdolhosseini et al. 2019, "On learning symmetric locomotion", compare ways to do
    this). Worlds in which left and right differ, such as people who pass on the right, should do without.

    Args:
        share: Share of the rows that are mirrored.
        seed: Seed of the choice of rows.

    Raises:
        ValueError: If ``share`` is not from 0 to 1.
    """

    def __init__(self, *, share: float = 0.5, seed: int = 0) -> None:
        super().__init__()
        if not 0.0 <= share <= 1.0:
            raise ValueError(f"share must be from 0 to 1, got {share!r}")
        self.share = share
        self.seed = seed
        self._mirror: Mirror | None = None
        self._channels_first = False

    def _on_training_start(self) -> None:
        check_mirrored(self.model)
        self._mirror = common_mirror(self.training_env)
        self._channels_first = is_vecenv_wrapped(self.training_env, VecTransposeImage)

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        """Mirror rows of the rollout. The choice depends on the seed and the number of steps alone."""
        assert self._mirror is not None, "it is made when the training starts"
        buffer: Any = self.model.rollout_buffer  # type: ignore[attr-defined]
        chosen = np.random.default_rng((self.seed, self.num_timesteps)).random(buffer.rewards.shape) < self.share
        seen = buffer.observations
        parts = seen if isinstance(seen, dict) else {"": seen}
        picked = {key: part[chosen] for key, part in parts.items()}
        given = picked if isinstance(seen, dict) else picked[""]
        mirrored = self._mirror.observation(given, channels_first=self._channels_first)
        for key, part in (mirrored if isinstance(mirrored, dict) else {"": mirrored}).items():
            parts[key][chosen] = part
        buffer.actions[chosen] = self._mirror.actions(buffer.actions[chosen])


def check_mirrored(model: Any) -> None:
    """Check that an algorithm can learn from mirrored rows, and that its environment can be mirrored.

    Raises:
        IrsimGymError: If it cannot; the message says why.
    """
    name = type(model).__name__
    if not isinstance(model, PPO) or isinstance(model, GruPPO):
        raise IrsimGymError(f"mirrored rows are for PPO, whose ratios weight them, and without memory; got {name}")
    if model.clip_range_vf is not None:
        raise IrsimGymError("clip_range_vf compares values of rows that are not mirrored: leave it out")
    env = model.get_env()
    assert env is not None
    normalized = unwrap_vec_normalize(env)
    if normalized is not None and normalized.norm_obs:
        raise IrsimGymError("observations normalised by VecNormalize cannot be mirrored: use norm_obs: false")
    mirror = common_mirror(env)
    for key, columns in mirror.vectors.items():
        shape = (env.observation_space[key] if key else env.observation_space).shape  # type: ignore[index]
        if shape != columns.columns.shape:
            raise IrsimGymError(f"a wrapper changes observations to the shape {shape}, so they cannot be mirrored")


def common_mirror(env: VecEnv) -> Mirror:
    """Return the mirror of all slots of an environment.

    Raises:
        IrsimGymError: If it is no environment of this package, has no mirror, or its slots have several.
    """
    if not env.has_attr("mirror"):
        raise IrsimGymError(f"mirrored rows need an environment of irsim_gym, got {env.unwrapped}")
    found: list[Mirror] = env.env_method("mirror")
    if not all(one is found[0] or _equal(one, found[0]) for one in found):
        raise IrsimGymError("mirrored rows need slots that observe and act alike")
    return found[0]


def _equal(one: Mirror, other: Mirror) -> bool:
    first, second = _tables(one), _tables(other)
    return first.keys() == second.keys() and all(np.array_equal(first[key], second[key]) for key in first)


def _tables(mirror: Mirror) -> dict[tuple[str, str], Any]:
    """Return all arrays of a mirror."""
    tables = {("action", ""): mirror.action, ("choices", ""): mirror.choices}
    tables |= {("image", key): columns for key, columns in mirror.images.items()}
    tables |= {("columns", key): part.columns for key, part in mirror.vectors.items()}
    return tables | {("signs", key): part.signs for key, part in mirror.vectors.items()}
