"""Hindsight replay of tasks that end when the agent arrives."""

from __future__ import annotations

from typing import Any

import numpy as np
from stable_baselines3 import HerReplayBuffer
from stable_baselines3.common.type_aliases import DictReplayBufferSamples

from irsim_gym.arraytypes import Ints, Rays


class EndingHerReplayBuffer(HerReplayBuffer):
    """``HerReplayBuffer`` in which an arrival that is replayed ends the episode, as one that happened does.

    That of Stable-Baselines3 pays it and goes on, as if standing at the goal were worth
    something. Infos are always kept (``copy_info_dict``).

    Args:
        *args: Arguments of ``HerReplayBuffer``.
        **options: Likewise, by name.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **{**options, "copy_info_dict": True})

    def _sample_goals(self, batch_indices: Ints, env_indices: Ints) -> Rays:
        self._goals: Rays = super()._sample_goals(batch_indices, env_indices)
        return self._goals

    def _get_virtual_samples(self, batch_indices: Ints, env_indices: Ints, env: Any = None) -> DictReplayBufferSamples:
        samples = super()._get_virtual_samples(batch_indices, env_indices, env)
        assert self.env is not None
        achieved = self.next_observations["achieved_goal"][batch_indices, env_indices]
        infos = self.infos[batch_indices, env_indices]
        (arrived,) = self.env.env_method("would_arrive", achieved, self._goals, infos, indices=[0])
        ends = self.to_torch(arrived.astype(np.float32)).reshape(-1, 1)
        return samples._replace(dones=samples.dones.maximum(ends))
