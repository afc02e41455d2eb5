"""``discrete``: a choice from a grid of commands."""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from irsim_gym.simulator.engine import Simulation
from irsim_gym.tasks.actions.commands import FRAME
from irsim_gym.tasks.terms import EpisodeState, Floats, Ints, Model, Shard, State, Term, kernel, kind, option


@kind
class DiscreteAction:
    """A discrete action: a grid of commands, evenly spaced between the limits, including the limits.

    Choice ``i * angular + j`` combines the i-th of ``linear`` values of the command's first component with the j-th of
    ``angular`` values of its last one, both ascending from ``vel_min``, so that right turns come first. With an odd
    number of values and symmetric limits, the middle value is 0. A drive with three components has ``lateral`` values
    of the second one: choice ``(i * lateral + l) * angular + j``.
    """

    linear: int = option(3, ge=1, le=1000, meaning="Number of values of the first component; 1: only the maximum.")
    lateral: int = option(1, ge=1, le=1000, meaning="Values of the second of three components; 1: only its middle.")
    angular: int = option(5, ge=1, le=1000, meaning="Number of values of the last component; 1: only its middle.")
    frame: Literal["body", "command"] = FRAME

    @property
    def n_choices(self) -> int:
        """Number of points of the grid."""
        return self.linear * self.lateral * self.angular

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]]:
        """Return the action in [-1, 1] of each choice, shape ``(n_agents, n_choices, n_components)``."""
        sizes = [len(simulation.scenario.bodies[int(b)].kinematics.command_names) for b in agents]
        grid = np.zeros((len(sizes), self.n_choices, max(sizes)))
        for a, size in enumerate(sizes):
            grid[a, :, :size] = self._grid(size)
        return {"grid": grid}

    def _grid(self, size: int) -> Floats:
        """Return the choices of a drive with ``size`` components, shape ``(n_choices, size)``."""
        first = np.linspace(-1.0, 1.0, self.linear) if self.linear > 1 else np.ones(1)
        between, last = (np.linspace(-1.0, 1.0, n) if n > 1 else np.zeros(1) for n in (self.lateral, self.angular))
        axes = (first, last) if size == 2 else (first, between, last)
        return np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)

    def samples(self, term: Term) -> Floats:
        """Return the action of each choice, ``(n_agents, n_choices, n_components)``."""
        grid: Floats = term.arrays["grid"]
        return grid

    @staticmethod
    def act(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Look up the actions of the learner's choices."""
        take_choice(shard.worlds, term.arrays["grid"], episode)


@kernel
def take_choice(worlds: Ints, grid: Floats, episode: EpisodeState) -> None:
    """Move the latest action to ``previous_action``, and write the chosen row of ``grid``.

    Reads: episode (action, choice).
    Writes: episode (action, previous_action).
    """
    for w in worlds:
        for a in range(episode.action.shape[1]):
            for c in range(episode.action.shape[2]):
                episode.previous_action[w, a, c] = episode.action[w, a, c]
                episode.action[w, a, c] = grid[a, episode.choice[w, a], c]
