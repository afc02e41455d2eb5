"""What environments of one learner have beside the methods of Gymnasium."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from irsim_gym.envs.description import Description
from irsim_gym.envs.mirror import Mirror
from irsim_gym.envs.worlds import Worlds


class Explained:
    """An environment around some worlds, which says what its numbers mean and what they would have been.

    Attributes:
        worlds: The worlds.
    """

    worlds: Worlds

    def describe(self) -> Description:
        """Return what observations, actions, rewards, endings and infos mean; it prints as tables."""
        return self.worlds.describe()

    def mirror(self) -> Mirror:
        """Return what exchanges left and right in observations and actions; an error says why it cannot be done."""
        return self.worlds.mirror()

    @property
    def compute_reward(self) -> Callable[[Any, Any, Any], Any]:
        """The reward of steps as if another place had been their goal, see ``Worlds.compute_reward``.

        It is there with ``observation_form: goal`` alone, because libraries take whatever has it for an environment
        with such observations.
        """
        form = self.worlds.task.observation_form
        if form != "goal":
            raise AttributeError(f"compute_reward is for tasks with observation_form: goal, this one's is '{form}'")
        return self.worlds.compute_reward
