"""Trajectories of agents in evaluated levels, for figures."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Rays
from irsim_gym.tasks import Episodes, Outcome

KEPT_LEVELS = 200
"""Number of first levels whose whole trajectories are kept; of the others, only the end is kept."""


class Watcher(Protocol):
    """Observes an evaluation without changing it."""

    def began(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Handle that levels have begun in worlds; ``indices`` are their positions among the evaluated levels."""

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Handle that worlds have taken a step."""

    def ended(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Handle that the episodes of all agents of worlds have ended."""


@dataclass(frozen=True)
class AgentTrajectory:
    """The trajectory of one agent in one level.

    Attributes:
        level: Position of the level among the evaluated ones.
        points: Its positions from start to end [m], float32 ``(n, 2)``; only the end if the trajectory was not kept.
        goal: Its last goal [m], ``(2,)``; NaN without one.
        outcome: How its episode ended, e.g. ``"collision"``.
    """

    level: int
    points: Rays
    goal: Floats
    outcome: str


@dataclass
class TrajectoryLog:
    """Keeps the trajectories of a policy: a `Watcher`.

    Args:
        shown: Number of levels whose whole trajectories are kept.

    Attributes:
        ways: The trajectories of all levels that have ended, in any order.
    """

    episodes: Episodes
    shown: int = KEPT_LEVELS
    ways: list[AgentTrajectory] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        shape = self.episodes.n_worlds, self.episodes.task.max_steps + 1, self.episodes.n_agents, 2
        self._points: Rays = np.zeros(shape, np.float32)
        self._count: Ints = np.zeros(shape[0], np.int64)
        self._kept = np.zeros(shape[0], np.bool_)

    def began(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Record the start positions of agents."""
        self._count[worlds], self._kept[worlds] = 0, indices < self.shown
        self.stepped(episodes, worlds)

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Record the positions of agents, in worlds whose trajectories are kept."""
        kept = worlds[self._kept[worlds]]
        if not len(kept):
            return
        simulation = episodes.simulation
        self._points[kept, self._count[kept]] = simulation.state.pose[kept[:, None], simulation.agents, :2]
        self._count[kept] += 1

    def ended(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Store the trajectories of worlds that have ended."""
        infos, simulation = episodes.view.infos, episodes.simulation
        for w, index in zip(worlds.tolist(), indices.tolist(), strict=True):
            for a, body in enumerate(simulation.agents.tolist()):
                last = int(infos["steps"][w, a]) + 1
                here = simulation.state.pose[w, body, :2].astype(np.float32)[None]
                count = int(simulation.model.waypoint_count[w, body])
                goal = simulation.model.waypoints[w, body, count - 1, :2] if count else np.full(2, np.nan)
                points = self._points[w, :last, a].copy() if self._kept[w] else here
                self.ways.append(
                    AgentTrajectory(index, points, goal.copy(), Outcome(int(infos["outcome"][w, a])).name.lower())
                )
