"""Measures how agents move: the derivatives of their true velocity, and how close they come to people."""

import math

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.evaluation.measures.people import PeopleLog
from irsim_gym.evaluation.measures.pushes import PushLog
from irsim_gym.tasks import Episodes, Outcome


class MotionLog:
    """Measures acceleration and jerk in the running episodes: a `Watcher`.

    Both are differences of the velocity vector in the world frame over a step, so that turning at full speed counts and
    turning on the spot does not. Steps that end in a collision are excluded, since a collision removes the velocity.

    Attributes:
        people: Measures how close agents come to people.
        pushes: Measures the work that agents do on what they push.
    """

    def __init__(self, episodes: Episodes) -> None:
        self.people, self.pushes = PeopleLog(episodes), PushLog(episodes)
        shape = episodes.n_worlds, episodes.n_agents
        self._count: Ints = np.zeros(shape, np.int64)
        self._velocity: Floats = np.zeros((*shape, 2))
        self._change: Floats = np.zeros((*shape, 2))
        self._sums: Floats = np.zeros((*shape, 2))

    def began(self, episodes: Episodes, worlds: Ints, indices: Ints) -> None:
        """Record the velocities at the start."""
        self.people.began(worlds)
        self.pushes.began(worlds)
        self._count[worlds], self._sums[worlds] = 0, 0.0
        self._velocity[worlds] = self._velocities(episodes, worlds)

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Add the motion of agents whose episode was running."""
        self.people.stepped(episodes, worlds)
        self.pushes.stepped(episodes, worlds)
        infos, dt = episodes.view.infos, float(episodes.simulation.model.step_time[0])
        count = self._count[worlds]
        steps = episodes.steps_to_arrival(worlds)
        counts = (steps > count) & (infos["outcome"][worlds] != Outcome.COLLISION)
        velocity = self._velocities(episodes, worlds)
        change = (velocity - self._velocity[worlds]) / dt
        turn = np.where((count > 0)[..., None], change - self._change[worlds], 0.0) / dt
        sizes = np.stack([np.hypot(*np.moveaxis(each, -1, 0)) for each in (change, turn)], axis=-1)
        self._sums[worlds] += np.where(counts[..., None], sizes, 0.0)
        self._count[worlds] += counts
        self._velocity[worlds], self._change[worlds] = velocity, change

    def acceleration(self, world: int, agent: int) -> float:
        """Return the mean size of an agent's acceleration [m/s2]; NaN without a step."""
        count = int(self._count[world, agent])
        return float(self._sums[world, agent, 0]) / count if count > 0 else math.nan

    def jerk(self, world: int, agent: int) -> float:
        """Return the mean size of an agent's jerk [m/s3]; NaN with fewer than two steps."""
        count = int(self._count[world, agent])
        return float(self._sums[world, agent, 1]) / (count - 1) if count > 1 else math.nan

    @staticmethod
    def _velocities(episodes: Episodes, worlds: Ints) -> Floats:
        twists: Floats = episodes.simulation.state.twist[worlds[:, None], episodes.simulation.agents, :2]
        return twists
