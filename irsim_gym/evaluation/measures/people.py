"""Measures how close agents come to people: bodies other than agents that move by themselves."""

import math

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats, Ints
from irsim_gym.tasks import Episodes

INTRUSIONS = 0.25, 0.45
"""Distances below which an agent intrudes [m]: the one of CrowdNav++ (Liu et al., ICRA 2023, arXiv:2203.01821), and the
intimate distance (Hall, The Hidden Dimension, 1966).
"""

HORIZON = 10.0
"""Later collisions do not count [s], since people hardly keep a velocity for longer."""


class PeopleLog:
    """Measures intrusions and times to collision in the running episodes.

    Every body counts as the disc around its origin that encloses it, which is exact for discs. Both measures are those
    of Francis et al. (Principles and Guidelines for Evaluating Social Robot Navigation Algorithms, 2023,
    arXiv:2306.16740): the share of steps with too little space, and the minimum time to collision.
    """

    def __init__(self, episodes: Episodes) -> None:
        model, agents = episodes.simulation.model, episodes.simulation.agents
        walks: Flags = model.movable & model.driven & ~model.unobstructed
        walks[agents] = False
        self._people = np.flatnonzero(walks)
        shape = episodes.n_worlds, episodes.n_agents
        self._count: Ints = np.zeros(shape, np.int64)
        self._near: Ints = np.zeros((*shape, len(INTRUSIONS)), np.int64)
        self._least: Floats = np.full(shape, np.inf)

    def began(self, worlds: Ints) -> None:
        """Discard earlier episodes."""
        self._count[worlds], self._near[worlds], self._least[worlds] = 0, 0, np.inf

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Measure the agents whose episode was running."""
        if not len(self._people):
            return
        runs = episodes.steps_to_arrival(worlds) > self._count[worlds]
        gap, time = self._look(episodes, worlds)
        for k, near in enumerate(INTRUSIONS):
            self._near[worlds, :, k] += runs & (gap < near)
        self._least[worlds] = np.where(runs, np.minimum(self._least[worlds], time), self._least[worlds])
        self._count[worlds] += runs

    def _look(self, episodes: Episodes, worlds: Ints) -> tuple[Floats, Floats]:
        """Return the minimum clearance [m] and time to collision [s] over all people, ``(n, n_agents)`` each."""
        model, state, agents = episodes.simulation.model, episodes.simulation.state, episodes.simulation.agents
        rows = worlds[:, None]
        reach = model.reach[worlds if len(model.reach) > 1 else np.zeros_like(worlds)]
        both = reach[:, agents, None] + reach[:, None, self._people]
        away = state.pose[rows, self._people, :2][:, None] - state.pose[rows, agents, :2][:, :, None]
        speed = state.twist[rows, self._people, :2][:, None] - state.twist[rows, agents, :2][:, :, None]
        present = model.present[rows, self._people][:, None]
        gap = np.where(present, np.hypot(away[..., 0], away[..., 1]) - both, np.inf)
        time = np.where(present, time_to_contact(away, speed, both), np.inf)
        return gap.min(axis=-1), time.min(axis=-1)

    def intrusion(self, world: int, agent: int, k: int) -> float:
        """Return the share of steps closer to a person than ``INTRUSIONS[k]``; NaN if there are no people."""
        count = int(self._count[world, agent])
        return int(self._near[world, agent, k]) / count if count > 0 else math.nan

    def time_to_collision(self, world: int, agent: int) -> float:
        """Return an agent's minimum time to collision [s]: infinite if it met nobody, NaN if there are no people."""
        return float(self._least[world, agent]) if self._count[world, agent] > 0 else math.nan


def time_to_contact(away: Floats, speed: Floats, both: Floats) -> Floats:
    """Return when discs touch if all keep their velocities [s]: 0 if they overlap, infinite beyond ``HORIZON``.

    It is the first root t of |p + v t| = R.

    Args:
        away: Relative positions of the others, p [m], shape ``(..., 2)``.
        speed: Relative velocities of the others, v [m/s], shape ``(..., 2)``.
        both: Sums of both radii, R [m], shape ``(...)``.
    """
    square, along = (speed * speed).sum(axis=-1), (away * speed).sum(axis=-1)
    beyond = (away * away).sum(axis=-1) - both * both
    root = along * along - square * beyond
    meets = (along < 0.0) & (root >= 0.0) & (beyond > 0.0)
    time = np.full(np.shape(beyond), np.inf)
    np.divide(beyond, np.sqrt(np.maximum(root, 0.0)) - along, out=time, where=meets)
    return np.where(beyond <= 0.0, 0.0, np.where(time <= HORIZON, time, np.inf))
