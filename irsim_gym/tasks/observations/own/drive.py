"""Drive: which of the learners' drives the agent has."""

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.families import KINEMATICS
from irsim_gym.simulator.world.names import Ints, Model, Rays, Shard, State, kernel, kind
from irsim_gym.tasks.terms import Columns, EpisodeState, Mirrored, RobotValues, Simulation, Term, Value, unchanged
from irsim_gym.tasks.terms.term import Needs


@kind
class Drive:
    """1 for the agent's own drive and 0 for the other drives of the learners, in the order of their names.

    A policy that robots with different drives share needs to know the drive of each robot.
    """

    needs_goal: ClassVar[bool] = False
    needs: ClassVar[Needs] = ()

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]]:
        """Return each agent's numbers, ``(n_agents, n_drives)``."""
        names = [KINEMATICS.name_of(type(simulation.scenario.bodies[int(b)].kinematics)) for b in agents]
        names_there = sorted(set(names))
        numbers = [KINEMATICS.names().index(name) for name in names_there]
        flags = np.array([[name == other for other in names_there] for name in names], np.float32)
        return {"own": flags, "drives": np.array(numbers, np.int64)}

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds, one element for each drive."""
        width = term.arrays["own"].shape[1]
        return np.zeros(width, np.float32), np.ones(width, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        return [
            Columns(f"1 where the robot's drive is {name}, else 0")
            for name in map(KINEMATICS.names().__getitem__, term.arrays["drives"])
        ]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns, which do not change."""
        return unchanged(term.arrays["own"].shape[1])

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        return robot.constant(term.arrays["own"][agent])

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the numbers."""
        write_drive(shard.worlds, term.column, term.arrays["own"], episode.observation)


@kernel
def write_drive(worlds: Ints, column: int, flags: Rays, out: Rays) -> None:
    """Copy each agent's row of ``flags``, ``(n_agents, n_drives)``."""
    for w in worlds:
        for a in range(flags.shape[0]):
            for k in range(flags.shape[1]):
                out[w, a, column + k] = flags[a, k]
