"""The geodesic optimum of a level: what a driven path is measured against."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.paths.queries import free_path_length
from irsim_gym.tasks import Episodes


class Optima:
    """Lengths of the shortest collision-free paths of one split's levels, each found once.

    The path leads from the start through all goals in turn, past the bodies that stand still, for a disc that holds the
    robot's footprint. It is the length of a path that exists: at most about 1 % above the true optimum.

    Args:
        split: The split of the levels.
    """

    def __init__(self, split: str) -> None:
        self.split = split
        self._known: dict[tuple[int, int], float] = {}

    def of(self, episodes: Episodes, world: int, level: int, agent: int = 0) -> float:
        """Return the optimum [m] of an agent in the level that a world plays; infinite where no path is found."""
        if (level, agent) not in self._known:
            self._known[level, agent] = self._measure(episodes, world, agent)
        return self._known[level, agent]

    @staticmethod
    def _measure(episodes: Episodes, world: int, agent: int) -> float:
        simulation = episodes.simulation
        model, state = simulation.model, simulation.state
        radius = float(model.reach[world % len(model.reach), simulation.agents[agent]])
        ways = pairwise(stops(episodes, world, agent))
        return sum(free_path_length(model, state, world, radius, begin, end) for begin, end in ways)


def stops(episodes: Episodes, world: int, agent: int) -> Floats:
    """Return an agent's start and its goals in turn, ``(n_goals + 1, 2)`` [m]."""
    model, state = episodes.simulation.model, episodes.simulation.state
    body = int(episodes.simulation.agents[agent])
    goals = model.waypoints[world, body, : int(state.waypoint_end[world, body]), :2]
    return np.concatenate([model.start[world, body, None, :2], goals])


def straight_distance(episodes: Episodes, world: int, agent: int) -> float:
    """Return the length of the straight way from an agent's start through its goals [m]."""
    steps = np.diff(stops(episodes, world, agent), axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
