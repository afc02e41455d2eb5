"""What environments of one learner have beside the methods of Gymnasium."""

from __future__ import annotations

from typing import Any

from irsim_gym.envs.description import Description
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

    def compute_reward(self, achieved_goal: Any, desired_goal: Any, info: Any) -> Any:
        """Return the reward of steps as if ``desired_goal`` had been their goal; for ``observation_form: goal``.

        Args:
            achieved_goal: Where they ended, as observed, ``(2,)`` or ``(n, 2)``.
            desired_goal: Where they should have ended, of the same shape.
            info: The info of the step; of several a sequence of infos, or the arrays of a vector environment.

        Returns:
            A float, or an array ``(n,)``: for the goal that the step really had, the reward that it was paid.

        Raises:
            IrsimGymError: The task has another ``observation_form``.
            ValueError: Shapes that do not fit, or an info that lacks the outcome or the reward terms.
        """
        return self.worlds.compute_reward(achieved_goal, desired_goal, info)
