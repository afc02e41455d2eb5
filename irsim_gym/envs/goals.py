"""The reward of a step as if another place had been the goal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from irsim_gym.arraytypes import Flags, Floats
from irsim_gym.envs.infos import reward_keys
from irsim_gym.errors import IrsimGymError
from irsim_gym.tasks import Episodes, Outcome
from irsim_gym.tasks.outcome import PRECEDENCE
from irsim_gym.tasks.rewards.arrival import Arrival

BEFORE_SUCCESS = tuple(int(outcome) for outcome in PRECEDENCE[: PRECEDENCE.index(Outcome.SUCCESS)])
ROUNDING = 1e-6
"""How far apart two observed places may seem that are the same, as a share of half the world's longer side."""
NO_INFO = (
    "compute_reward needs the info of each step, with the outcome, the distance and all reward terms; "
    "Stable-Baselines3 keeps it with replay_buffer_kwargs={'copy_info_dict': True}"
)


class GoalReward:
    """Computes rewards for other goals: ``arrival`` is recomputed, the other terms come from the info.

    Args:
        episodes: A task with ``observation_form: goal``.

    Raises:
        IrsimGymError: The task has another form, or the worlds have different goal thresholds.
    """

    def __init__(self, episodes: Episodes) -> None:
        task, model = episodes.task, episodes.simulation.model
        if task.observation_form != "goal":
            form = task.observation_form
            raise IrsimGymError(f"compute_reward is for tasks with observation_form: goal, this one's is '{form}'")
        thresholds = np.unique(model.goal_threshold[:, task.agents[0]])
        if len(thresholds) > 1:
            raise IrsimGymError("compute_reward needs one goal_threshold for all worlds, and they have different ones")
        x_min, y_min, x_max, y_max = model.bounds.tolist()
        self._half, self._threshold = 0.5 * max(x_max - x_min, y_max - y_min), float(thresholds[0])
        self._keys = reward_keys(episodes.reward_names)
        self._bonus = {
            key: float(term.weight)
            for key, term in zip(self._keys, task.rewards, strict=True)
            if isinstance(term, Arrival)
        }

    def __call__(self, achieved_goal: Any, desired_goal: Any, info: Any) -> Any:
        """Return the reward of steps.

        Args:
            achieved_goal: Where they ended, as observed, ``(2,)`` or ``(n, 2)``.
            desired_goal: Where they should have ended, of the same shape.
            info: The info of the step; of several a sequence of infos, or the arrays of a vector environment.

        Returns:
            A float, or an array float64 ``(n,)``.

        Raises:
            ValueError: The goals have other shapes, or an info does not tell what is needed.
        """
        achieved, desired = np.asarray(achieved_goal, np.float64), np.asarray(desired_goal, np.float64)
        if achieved.shape != desired.shape or achieved.shape[-1:] != (2,) or achieved.ndim > 2:
            shapes = f"{achieved.shape} and {desired.shape}"
            raise ValueError(f"goals must both have shape (2,) or (n, 2), got {shapes}")
        count = achieved.shape[:-1]
        infos = info if isinstance(info, Mapping) else _together(info, self._keys)
        reward: Floats = np.zeros(count)
        try:
            arrived = self._arrived(achieved, desired, infos)
            for key in self._keys:
                bonus = self._bonus.get(key)
                reward = reward + (np.asarray(infos[key]) if bonus is None else np.where(arrived, bonus, 0.0))
        except KeyError:
            raise ValueError(NO_INFO) from None
        return reward if count else float(reward)

    def arrived(self, achieved_goal: object, desired_goal: object, infos: Sequence[Mapping[str, object]]) -> Flags:
        """Return which steps would have arrived, ``(n,)``; the arguments are those of a call, for several steps."""
        achieved, desired = np.asarray(achieved_goal, np.float64), np.asarray(desired_goal, np.float64)
        return self._arrived(achieved, desired, _together(infos, self._keys))

    def _arrived(self, achieved: Floats, desired: Floats, infos: Mapping[str, Any]) -> Flags:
        near = self._distance(achieved, desired, np.asarray(infos["goal_distance"])) < self._threshold
        arrived: Flags = near & ~np.isin(infos["outcome"], BEFORE_SUCCESS)
        return arrived

    def _distance(self, achieved: Floats, desired: Floats, real: Floats) -> Floats:
        """Return distances [m]; the one that the step itself measured where the goal is its own, or as far away.

        Observed places have the digits of float32, which at the threshold itself may say otherwise than the step.
        """
        found = self._half * np.hypot(*np.moveaxis(desired - achieved, -1, 0))
        return np.where(np.abs(found - real) < ROUNDING * self._half, real, found)


def _together(infos: Sequence[Mapping[str, object]], keys: Sequence[str]) -> dict[str, Any]:
    """Return the infos of several steps as arrays."""
    try:
        terms = {key: np.array([info[key] for info in infos], np.float64) for key in keys}
        distance = np.array([info["goal_distance"] for info in infos], np.float64)
        outcome = np.array([info["outcome"] for info in infos], np.int64)
        return {"outcome": outcome, "goal_distance": distance, **terms}
    except KeyError:
        raise ValueError(NO_INFO) from None
