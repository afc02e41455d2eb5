"""Last action: the latest action of the agent."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Flags, Ints, Model, Rays, Shard, State, kernel, kind
from irsim_gym.tasks.terms import Columns, EpisodeState, Mirrored, Needs, RobotValues, Term, Value, command_exchanged


@kind
class LastAction:
    """The latest action, scaled to [-1, 1] as continuous actions are; at the start, the action for standing still."""

    needs_goal: ClassVar[bool] = False
    needs: ClassVar[Needs] = ()

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds, one element for each component of the command."""
        size = term.action_size
        return np.full(size, -1.0, np.float32), np.ones(size, np.float32)

    def used(self, term: Term) -> Flags:
        """Return flags of the components that each agent's drive has, ``(n_agents, action_size)``."""
        return np.arange(term.action_size) < term.action_sizes[:, None]

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns; components that an agent lacks are 0."""
        words = term.components[agent]
        named = [Columns(f"{name}, as requested", "-1 to 1, like actions") for name, _ in words]
        return [*named, *[Columns("unused")] * (term.action_size - len(words))]

    def mirrored(self, term: Term) -> Mirrored | str:
        """Return the columns as the drive says; what is positive to the left changes its sign."""
        return command_exchanged(term)

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        return robot.action

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the action."""
        write_action(shard.worlds, term.column, episode)


@kernel
def write_action(worlds: Ints, column: int, episode: EpisodeState) -> None:
    """Copy the agents' actions, ``(n_worlds, n_agents, n_components)``.

    Reads: episode (action).
    Writes: episode (observation).
    """
    for w in worlds:
        for a in range(episode.action.shape[1]):
            for c in range(episode.action.shape[2]):
                episode.observation[w, a, column + c] = np.float32(episode.action[w, a, c])
