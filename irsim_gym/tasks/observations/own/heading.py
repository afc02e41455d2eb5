"""Heading: the heading of the agent in the world."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Ints, Model, Rays, Shard, State, kernel, kind
from irsim_gym.tasks.terms import IN_WORLD, Columns, EpisodeState, Needs, RobotValues, Term, Value


@kind
class Heading:
    """Cosine and sine of the heading in the world."""

    needs_goal: ClassVar[bool] = False
    needs: ClassVar[Needs] = ("map_frame",)

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the two elements."""
        return np.full(2, -1.0, np.float32), np.ones(2, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        world = "in the world: 0 along x, positive to y"
        return [Columns("cosine of the heading", world), Columns("sine of the heading", world)]

    def mirrored(self, term: Term) -> str:
        """Return why it has no mirror: it is in the frame of the world."""
        return IN_WORLD

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        return robot.pose.columns(2, 3).unit().cast(np.float32)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the two elements."""
        write_heading(shard.worlds, term.agents, term.column, state, episode)


@kernel
def write_heading(worlds: Ints, agents: Ints, column: int, state: State, episode: EpisodeState) -> None:
    """Write cosine and sine of the headings of poses ``(n_worlds, n_bodies, 3)`` [m, m, rad].

    Reads: state (pose).
    Writes: episode (observation).
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            episode.observation[w, a, column] = np.float32(np.cos(state.pose[w, agents[a], 2]))
            episode.observation[w, a, column + 1] = np.float32(np.sin(state.pose[w, agents[a], 2]))
