"""Has arrived: whether the agent has already reached its goal and drives on."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Ints, Model, Rays, Shard, State, kernel, kind
from irsim_gym.tasks.terms import Columns, EpisodeState, Mirrored, Needs, Term, unchanged


@kind
class HasArrived:
    """1 if the agent has reached its last goal and drives on, else 0; always 0 unless ``arrived`` has ``wait``."""

    needs_goal: ClassVar[bool] = True
    needs: ClassVar[Needs] = ("odometry",)

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the element."""
        return np.zeros(1, np.float32), np.ones(1, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the column."""
        return [Columns("1 if it has reached its last goal and drives on, else 0")]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the column, which does not change."""
        return unchanged(1)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the element."""
        write_arrivals(shard.worlds, term.column, episode)


@kernel
def write_arrivals(worlds: Ints, column: int, episode: EpisodeState) -> None:
    """Write whether each agent has arrived.

    Reads: episode (arrival).
    Writes: episode (observation).
    """
    for w in worlds:
        for a in range(episode.arrival.shape[1]):
            episode.observation[w, a, column] = np.float32(1.0 if episode.arrival[w, a] > 0 else 0.0)
