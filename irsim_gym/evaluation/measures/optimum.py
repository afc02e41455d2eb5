"""The geodesic optimum of a level, to which driven paths are compared."""

import math
from itertools import pairwise

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.evaluation.measures.certificate_measures import least_steps
from irsim_gym.simulator.cell_paths.queries import free_path_length
from irsim_gym.tasks import Episodes, Task


class Optima:
    """Lengths and least times of the shortest collision-free paths in the levels of one split: a `Watcher`.

    The path leads from the start through all goals in order, among the standing obstacles, for a disc that encloses the
    robot's footprint. The result is the length of an existing path, at most about 1 % above the true optimum. It is
    computed once per level, however many policies play it.
    """

    def __init__(self, split: str) -> None:
        self.split = split
        self._legs: dict[tuple[int, int], list[float]] = {}
        self._times: dict[tuple[int, int], float] = {}

    def of(self, episodes: Episodes, world: int, level: int, agent: int = 0) -> float:
        """Return the optimum [m] of an agent in the level that a world plays; infinite if no path is found."""
        return sum(self._legs_of(episodes, world, level, agent))

    def least_time(self, level: int, agent: int = 0) -> float:
        """Return the least time [s] of an agent in a level that was watched when it began; NaN for other levels."""
        return self._times.get((level, agent), math.nan)

    def began(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Compute the least times from the velocities at the start; infinite if no path is found."""
        simulation, levels = episodes.simulation, episodes.view.infos["level"]
        model, state = simulation.model, simulation.state
        for world in worlds.tolist():
            for agent, body in enumerate(simulation.agents.tolist()):
                key = int(levels[world, agent]), agent
                if key not in self._times:
                    steps = least_steps(model, state, world, body, self._legs_of(episodes, world, *key))
                    self._times[key] = steps * float(model.step_time[0])

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Do nothing."""

    def _legs_of(self, episodes: Episodes, world: int, level: int, agent: int) -> list[float]:
        """Return the lengths of the paths from goal to goal [m]."""
        if (level, agent) not in self._legs:
            self._legs[level, agent] = self._measure(episodes, world, agent)
        return self._legs[level, agent]

    @staticmethod
    def _measure(episodes: Episodes, world: int, agent: int) -> list[float]:
        if not heeds_goals(episodes.task):
            return [math.inf]
        simulation = episodes.simulation
        model, state = simulation.model, simulation.state
        radius = float(model.reach[world % len(model.reach), simulation.agents[agent]])
        ways = pairwise(stops(episodes, world, agent))
        return [free_path_length(model, state, world, radius, begin, end) for begin, end in ways]


def heeds_goals(task: Task) -> bool:
    """Return whether a task is about the goals of its robots, and not, for example, about those of bodies they push."""
    return any(term.needs_goal for term in (*task.observations, *task.rewards, *task.endings))


def stops(episodes: Episodes, world: int, agent: int) -> Floats:
    """Return an agent's start and its goals in order, ``(n_goals + 1, 2)`` [m]."""
    model, state = episodes.simulation.model, episodes.simulation.state
    body = int(episodes.simulation.agents[agent])
    goals = model.waypoints[world, body, : int(state.waypoint_end[world, body]), :2]
    return np.concatenate([model.start[world, body, None, :2], goals])


def straight_distance(episodes: Episodes, world: int, agent: int) -> float:
    """Return the length of the straight lines from an agent's start through its goals [m]."""
    steps = np.diff(stops(episodes, world, agent), axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
