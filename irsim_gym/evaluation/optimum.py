"""The geodesic optimum of a level: what a driven path is measured against."""

from __future__ import annotations

from itertools import pairwise

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
        self._known: dict[int, float] = {}

    def of(self, episodes: Episodes, world: int, level: int) -> float:
        """Return the optimum [m] of the level that a world plays; infinite where no path is found."""
        if level not in self._known:
            self._known[level] = self._measure(episodes, world)
        return self._known[level]

    @staticmethod
    def _measure(episodes: Episodes, world: int) -> float:
        simulation, agent = episodes.simulation, int(episodes.simulation.agents[0])
        model, state = simulation.model, simulation.state
        radius = float(model.reach[world % len(model.reach), agent])
        goals = model.waypoints[world, agent, : int(state.waypoint_end[world, agent]), :2]
        stops = [model.start[world, agent, :2], *goals]
        return sum(free_path_length(model, state, world, radius, begin, end) for begin, end in pairwise(stops))
