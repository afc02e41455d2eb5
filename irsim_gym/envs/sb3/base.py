"""What the environments for Stable-Baselines3 share: how its methods reach a world or an agent."""

import time
import warnings
from collections.abc import Iterable, Mapping, Sequence
from itertools import repeat
from typing import Any

import gymnasium
import numpy as np
from gymnasium import Space
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv

from irsim_gym.base.arraytypes import Bytes, Flags, Floats, Ints
from irsim_gym.envs.gymnasium.explained import Explained
from irsim_gym.envs.gymnasium.world_view import WorldView, common_limit
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.envs.parts.infos import Record

Indices = None | int | Iterable[int]


class NativeVecEnv(Explained, VecEnv):
    """A ``VecEnv`` over worlds that are stepped together.

    Args:
        views: What each slot shows to ``get_attr``, ``set_attr`` and ``env_method``.
        observation_space: Of one slot.
        action_space: Of one slot.

    Attributes:
        statistics_asked: The latest question was for a ``Monitor``, see ``env_is_wrapped``.
    """

    statistics_asked = False

    def __init__(
        self, worlds: Worlds, views: Sequence[WorldView], observation_space: Space[Any], action_space: Space[Any]
    ) -> None:
        self.worlds = worlds
        self._started = time.time()
        self.views = views
        self._record = Record(worlds.infos)
        super().__init__(len(views), observation_space, action_space)
        self.metadata: dict[str, Any] = {**self.metadata, "render_fps": worlds.render_fps}

    @property
    def reset_infos(self) -> list[dict[str, Any]]:
        """Infos at the beginning of each slot's latest episode; made on access, which is rare."""
        begun = np.flatnonzero(self._begun)
        for slot, info in zip(begun.tolist(), self._record.infos_of(begun), strict=True):
            self._reset_infos[slot] = info
        self._begun[:] = False
        return self._reset_infos

    @reset_infos.setter
    def reset_infos(self, infos: list[dict[str, Any]]) -> None:
        self._begun: Flags = np.zeros(len(infos), np.bool_)
        self._reset_infos = infos

    def note_beginnings(self, slots: Ints) -> None:
        """Record the infos of slots whose episodes have just begun, for ``reset_infos``."""
        self._record.note(slots)
        self._begun[slots] = True

    def no_infos(self) -> list[dict[str, Any]]:
        """Return a separate dict for each slot, because wrappers may write into them."""
        return list(map(dict.copy, repeat({}, self.num_envs)))

    def episode(self, total: float, info: Mapping[str, Any]) -> dict[str, Any]:
        """Return the statistics of an episode that has just ended, as ``Monitor`` does: return, length and time [s]."""
        return {"r": round(total, 6), "l": info["steps"], "t": round(time.time() - self._started, 6)}

    @property
    def reward_names(self) -> tuple[str, ...]:
        """Names of the reward terms, the columns of ``reward_terms``."""
        return tuple(self.worlds.episodes.reward_names)

    def reward_terms(self) -> Floats:
        """Return what each reward term paid in the latest step, ``(n_envs, n_terms)``, fresh; 0 where a slot has begun.

        The names of the columns are ``reward_names``.
        """
        terms = self.worlds.episodes.view.reward_terms
        return terms.reshape(self.num_envs, terms.shape[-1]).copy()

    def close(self) -> None:
        """Close the window, and free the renderer. May be called twice."""
        self.worlds.close()

    def render(self, mode: str | None = None) -> Bytes | None:
        """Return or show the worlds side by side.

        Args:
            mode: ``"rgb_array"`` returns a picture, ``"human"`` shows the worlds in a window, sixteen at most, not
                faster than in real time; None does what the environment was made for. An environment that was made
                for a window shows itself at each step.
        """
        if mode == "human" and self.render_mode == "rgb_array":
            self.worlds.pictures.show()
            return None
        return super().render(mode)

    def get_images(self) -> Sequence[Bytes | None]:
        """Return a fresh picture of each world."""
        pictures = self.worlds.pictures
        if pictures.mode is None:
            warnings.warn("the environment was made without a render mode: use render_mode='rgb_array'", stacklevel=2)
            return [None] * self.worlds.n_worlds
        return list(pictures.several(range(self.worlds.n_worlds)))

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """Return an attribute of the chosen slots; see ``WorldView``."""
        return [view.get_wrapper_attr(attr_name) for view in self._chosen(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Set an attribute of the chosen slots; ``max_steps``, the time limit [steps], for all of them alone."""
        chosen = self._chosen(indices)
        if attr_name == "max_steps":
            self.worlds.limit(common_limit([value] * len(chosen), self.num_envs))
            return
        for view in chosen:
            view.set_wrapper_attr(attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Indices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the chosen slots; see ``WorldView``."""
        return [view.get_wrapper_attr(method_name)(*method_args, **method_kwargs) for view in self._chosen(indices)]

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper[Any, Any, Any, Any]], indices: Indices = None
    ) -> list[bool]:
        """Return True for ``Monitor``, whose statistics of episodes the infos hold, and False for all other wrappers.

        ``evaluate_policy`` therefore reads these statistics, and ``VecMonitor`` warns that it overwrites them, as it
        does around the environments of Stable-Baselines3's own ``make_vec_env``. It is not needed.
        """
        self.statistics_asked = issubclass(Monitor, wrapper_class)
        return [self.statistics_asked] * len(self._chosen(indices))

    def _chosen(self, indices: Indices) -> list[WorldView]:
        return [self.views[slot] for slot in self._get_indices(indices)]


def checked_mode(mode: str | None) -> str | None:
    """Return a render mode, or raise a ValueError that lists those that Stable-Baselines3 knows."""
    if mode not in (None, "rgb_array", "human"):
        raise ValueError(f"render_mode must be None, 'rgb_array' or 'human' for Stable-Baselines3, got {mode!r}")
    return mode
