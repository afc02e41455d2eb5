"""Rewards that know which slots acted, so that buffers can tell experience from waiting."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from types import FrameType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv, VecMonitor

from irsim_gym.arraytypes import Flags

CALLERS = 24
"""How many callers are looked through for an algorithm: more than wrappers put between it and its environment."""


class SlotRewards(np.ndarray[Any, np.dtype[Any]]):
    """Rewards ``(n_slots,)`` that carry the mask of the slots that acted.

    Of all that a step returns, Stable-Baselines3 hands the rewards alone to the rollout buffer in the same call as the
    actions. The mask therefore comes with the data, whatever environment a model is set to or loaded with; no buffer
    has to know an environment. It stays through arithmetic, as wrappers that scale or normalise rewards do.

    Attributes:
        acted: Slots whose row is experience, ``(n_slots,)``; None in a copy that has lost it.
    """

    acted: Flags | None

    def __array_finalize__(self, obj: Any) -> None:
        self.acted = getattr(obj, "acted", None)

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        """Sums and means are plain numbers."""
        if np.ndim(array) == 0:
            return np.asarray(array)[()]
        wrapped = np.asarray(array).view(SlotRewards)
        wrapped.acted = self.acted
        return wrapped


def slot_rewards(reward: NDArray[Any], acted: Flags) -> SlotRewards:
    """Return float32 rewards, fresh, that carry the mask ``acted``; both have shape ``(n_slots,)``."""
    rewards = np.array(reward, np.float32).view(SlotRewards)
    rewards.acted = acted
    return rewards


def acted_of(reward: Any) -> Flags:
    """Return the mask that rewards carry.

    Raises:
        TypeError: They carry none: the environment is no team, or a wrapper has put other rewards in their place.
    """
    acted: Flags | None = getattr(reward, "acted", None)
    if acted is None or acted.shape != np.shape(reward):
        raise TypeError(
            "these rewards do not say which slots acted: masked buffers are for make_multi_agent_vec_env, and wrappers "
            "around it have to compute with the rewards that they get (rewards * 2, not numpy.array(rewards) * 2)"
        )
    return acted


def is_monitored(env: VecEnv) -> bool:
    """Return whether a ``VecMonitor`` around ``env`` steps it right now."""
    for frame in _callers():
        caller = frame.f_locals.get("self")
        if isinstance(caller, VecMonitor) and caller.unwrapped is env:
            return True
    return False


def is_being_monitored() -> bool:
    """Return whether a ``VecMonitor`` is being made right now: it asks what is below it, but does not say who asks."""
    return any(
        frame.f_code.co_name == "__init__" and isinstance(frame.f_locals.get("self"), VecMonitor)
        for frame in _callers()
    )


def learner_buffer(env: VecEnv) -> Any | None:
    """Return the buffer for which Stable-Baselines3 steps ``env`` right now; None if it does not collect experience.

    An environment is never told who steps it, nor why. Looking for ``collect_rollouts`` among the callers tells
    learning from evaluating and from loops of one's own, which may leave rows out as they like.
    """
    for frame in _callers():
        if frame.f_code.co_name == "collect_rollouts":
            found = frame.f_locals
            if getattr(found.get("env"), "unwrapped", None) is env:
                return found.get("rollout_buffer", found.get("replay_buffer"))
    return None


def _callers() -> Iterator[FrameType]:
    """Yield who called the function that asks, the nearest first."""
    frame: FrameType | None = sys._getframe(2)  # of this generator, and of who asks
    for _ in range(CALLERS):
        if frame is None:
            return
        yield frame
        frame = frame.f_back
