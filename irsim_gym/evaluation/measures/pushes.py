"""Measures what agents do to bodies that they push: the work, and how many lie in their targets at the end."""

import math

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.endings.bodies_arrived import BodiesArrived
from irsim_gym.tasks.terms.targets import lies_there


class PushLog:
    """Adds up the work of each agent against what it touches; nothing without contacts."""

    def __init__(self, episodes: Episodes) -> None:
        self._pushing = episodes.simulation.context.pushing
        self._work: Floats = np.zeros((episodes.n_worlds, episodes.n_agents))

    def began(self, worlds: Ints) -> None:
        """Forget what was done before."""
        self._work[worlds] = 0.0

    def stepped(self, episodes: Episodes, worlds: Ints) -> None:
        """Add the work of the step."""
        if self._pushing is not None:
            simulation, rows = episodes.simulation, (worlds[:, None], episodes.simulation.agents)
            felt, twist = self._pushing.felt[rows], simulation.state.twist[rows]
            power = -(felt["x"] * twist[..., 0] + felt["y"] * twist[..., 1])
            self._work[worlds] += np.maximum(power, 0.0) * float(simulation.model.step_time[0])

    def effort(self, world: int, agent: int) -> float:
        """Return an agent's work [J]; NaN where bodies do not push each other."""
        return math.nan if self._pushing is None else float(self._work[world, agent])


def delivered(episodes: Episodes, world: int) -> float:
    """Return the share of bodies that lie in their targets; NaN if the task does not end with ``bodies_arrived``."""
    model, state = episodes.simulation.model, episodes.simulation.state
    terms = [term for term in episodes.terms["endings"] if isinstance(term.options, BodiesArrived)]
    placed = ((term, b) for term in terms for b in term.arrays.bodies if model.present[world, b])
    there = [lies_there(world, b, term.arrays.area, model, state) for term, b in placed]
    return float(np.mean(there)) if there else math.nan
