"""What the environments for Stable-Baselines3 share: how its methods reach a world or an agent."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from itertools import repeat
from typing import Any

import gymnasium
import numpy as np
from gymnasium import Space
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecEnv

from irsim_gym.arraytypes import Bytes, Flags, Ints
from irsim_gym.envs.infos import Record
from irsim_gym.envs.worlds import Worlds

Indices = None | int | Iterable[int]


class NativeVecEnv(VecEnv):
    """A ``VecEnv`` over worlds that are stepped together.

    Args:
        worlds: The worlds.
        views: What each slot shows to ``get_attr``, ``set_attr`` and ``env_method``.
        observation_space: Of one slot.
        action_space: Of one slot.
    """

    def __init__(
        self, worlds: Worlds, views: Sequence[WorldView], observation_space: Space[Any], action_space: Space[Any]
    ) -> None:
        self.worlds = worlds
        self.views = views
        self._record = Record(worlds.infos)
        super().__init__(len(views), observation_space, action_space)
        self.metadata: dict[str, Any] = {**self.metadata, "render_fps": worlds.render_fps}

    @property
    def reset_infos(self) -> list[dict[str, Any]]:
        """What each slot's latest episode began with; made when it is asked for, as hardly anybody does."""
        begun = np.flatnonzero(self._begun)
        for slot, info in zip(begun.tolist(), self._record.told(begun), strict=True):
            self._reset_infos[slot] = info
        self._begun[:] = False
        return self._reset_infos

    @reset_infos.setter
    def reset_infos(self, infos: list[dict[str, Any]]) -> None:
        self._begun: Flags = np.zeros(len(infos), np.bool_)
        self._reset_infos = infos

    def note_beginnings(self, slots: Ints) -> None:
        """Keep what ``reset_infos`` tells about slots whose episodes have just begun."""
        self._record.note(slots)
        self._begun[slots] = True

    def no_infos(self) -> list[dict[str, Any]]:
        """Return a dict of its own for each slot, as wrappers may write into any; this is the fastest way."""
        return list(map(dict.copy, repeat({}, self.num_envs)))

    def close(self) -> None:
        """Close the window and free the renderer. May be called twice."""
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
        """Set an attribute of the chosen slots."""
        for view in self._chosen(indices):
            view.set_wrapper_attr(attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Indices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the chosen slots; see ``WorldView``."""
        return [getattr(view, method_name)(*method_args, **method_kwargs) for view in self._chosen(indices)]

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper[Any, Any, Any, Any]], indices: Indices = None
    ) -> list[bool]:
        """Answer True for ``Monitor`` alone: its statistics are there."""
        return [issubclass(wrapper_class, Monitor)] * len(self._chosen(indices))

    def _chosen(self, indices: Indices) -> list[WorldView]:
        return [self.views[slot] for slot in self._get_indices(indices)]


def checked_mode(mode: str | None) -> str | None:
    """Return a render mode, or raise a ValueError that lists those that Stable-Baselines3 knows."""
    if mode not in (None, "rgb_array", "human"):
        raise ValueError(f"render_mode must be None, 'rgb_array' or 'human' for Stable-Baselines3, got {mode!r}")
    return mode


class WorldView:
    """One world, or one agent of a world: what ``get_attr``, ``set_attr`` and ``env_method`` reach."""

    def __init__(self, worlds: Worlds, index: int, agent: int = 0) -> None:
        self.worlds = worlds
        self.index = index
        self.agent = agent
        self.spec: Any = None

    @property
    def render_mode(self) -> str | None:
        """``"rgb_array"``, ``"human"`` or None."""
        return self.worlds.render_mode

    @property
    def observation_space(self) -> Any:
        """The space of an agent's observations."""
        return self.worlds.observation_space

    @property
    def action_space(self) -> Any:
        """The space of an agent's actions."""
        return self.worlds.action_space

    @property
    def unwrapped(self) -> WorldView:
        """Itself."""
        return self

    def info(self) -> dict[str, Any]:
        """Return what is known about the agent now."""
        return self.worlds.info_of(self.index, self.agent)

    def action_masks(self) -> Flags:
        """Return which choices are worth trying, ``(n_choices,)``: what ``MaskablePPO`` of sb3-contrib asks for."""
        return np.asarray(self.worlds.action_masks()[self.index, self.agent])

    def compute_reward(self, achieved_goal: Any, desired_goal: Any, info: Any) -> Any:
        """Return the reward of steps as if another place had been the goal, see ``WorldEnv.compute_reward``."""
        return self.worlds.compute_reward(achieved_goal, desired_goal, info)

    def render(self) -> Any:
        """Return a fresh picture of the world; None without a render mode, or with a window."""
        return self.worlds.pictures.of(self.index)

    def has_wrapper_attr(self, name: str) -> bool:
        """Say whether there is such an attribute."""
        return hasattr(self, name)

    def get_wrapper_attr(self, name: str) -> Any:
        """Return an attribute."""
        return getattr(self, name)

    def set_wrapper_attr(self, name: str, value: Any) -> None:
        """Set an attribute; it belongs to this slot alone."""
        setattr(self, name, value)
