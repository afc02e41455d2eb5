"""Which choices of a discrete action are worth trying."""

from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Flags
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.tasks import Episodes


class ActionMasks:
    """Says which choices an agent has; True for all where nothing speaks against one.

    A choice is False where its command is that of another choice with a smaller number, because ``vel_min`` and
    ``vel_max`` leave a component no range. Nothing else is forbidden: limits of acceleration change from step to step
    what a command comes to, and where a choice leads to is for the learner to find out.

    Args:
        episodes: A task with ``action: discrete``.

    Raises:
        IrsimGymError: The task's actions are no choices.
    """

    def __init__(self, episodes: Episodes) -> None:
        if not episodes.n_discrete:
            raise IrsimGymError("action_masks is for tasks with choices (action: discrete); this one's are continuous")
        action, simulation = episodes.task.action, episodes.simulation
        agents = np.array(episodes.task.agents, np.int64)
        self._shape = episodes.n_worlds, len(agents), episodes.n_discrete
        arrays: dict[str, Any] = action.arrays(simulation, agents) if hasattr(action, "arrays") else {}
        self._grid = arrays.get("grid")
        self._limits = simulation.model.velocity_min, simulation.model.velocity_max
        self._agents = agents

    def all(self) -> Flags:
        """Return a fresh mask for each agent of each world, ``(n_worlds, n_agents, n_choices)``."""
        masks = np.ones(self._shape, np.bool_)
        if self._grid is None:
            return masks
        low, high = (limit[:, self._agents, : self._grid.shape[2]] for limit in self._limits)
        for a, choices in enumerate(self._grid):
            moves = low[:, a] < high[:, a]
            for some in np.unique(moves, axis=0):
                first = np.unique(np.where(some, choices, 0.0), axis=0, return_index=True)[1]
                worlds = slice(None) if len(moves) == 1 else np.flatnonzero((moves == some).all(axis=1))
                masks[worlds, a] = np.isin(np.arange(self._shape[2]), first)
        return masks
