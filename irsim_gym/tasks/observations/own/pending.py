"""Pending: the latest actions of the agent, of which some are still under way."""

from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Flags, Floats, Ints, Model, Rays, Shard, State, kernel, kind, option
from irsim_gym.tasks.terms import Columns, EpisodeState, Needs, RobotValues, Simulation, Term, Value
from irsim_gym.tasks.terms.mirrored import Mirrored, command_exchanged


@kind
class Pending:
    """The latest actions, newest first, each as in ``last_action``: with a latency, these commands are still under way.

    Before the first one, they are the action for standing still.
    """

    needs_goal: ClassVar[bool] = False
    needs: ClassVar[Needs] = ()

    steps: int = option(5, ge=1, le=1000, meaning="Number of actions.")

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, Floats]:
        """Return the actions by their step modulo ``steps``, ``(n_worlds, n_agents, steps, 3)``."""
        return {"sent": np.zeros((simulation.n_worlds, len(agents), self.steps, 3))}

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds, one element for each component of each command."""
        size = self.steps * term.action_size
        return np.full(size, -1.0, np.float32), np.ones(size, np.float32)

    def used(self, term: Term) -> Flags:
        """Return flags of the components that each agent's drive has, ``(n_agents, steps * action_size)``."""
        return np.tile(np.arange(term.action_size), self.steps) < term.action_sizes[:, None]

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns; components that an agent lacks are 0."""
        words, size = term.components[agent], term.action_size
        newest = [Columns(f"{name}, as requested last", "-1 to 1, like actions") for name, _ in words]
        rest = Columns(f"the same of the {self.steps - 1} actions before, newest first", count=size * (self.steps - 1))
        return [*newest, *[Columns("unused")] * (size - len(words)), *([rest] if self.steps > 1 else [])]

    def mirrored(self, term: Term) -> Mirrored | str:
        """Return the columns as the drive says; what is positive to the left changes its sign."""
        exchanged = command_exchanged(term)
        if isinstance(exchanged, str):
            return exchanged
        first = term.action_size * np.arange(self.steps)[:, None]
        return Mirrored((first + exchanged.columns).reshape(-1), np.tile(exchanged.signs, self.steps))

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        # At first, nothing is remembered (NaN), and the action is the one for standing still.
        graph, action = robot.graph, robot.action.spread(1)
        sent = graph.state("sent_actions", np.full((self.steps, term.action_size), np.nan, np.float32))
        sent_actions = graph.join([action, sent.is_nan().where(action, sent)]).columns(0, self.steps)
        graph.keep("sent_actions", sent_actions)
        return sent_actions.op("Flatten")

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the actions."""
        write_actions(shard.worlds, term.column, term.arrays["sent"], episode)


@kernel
def write_actions(worlds: Ints, column: int, sent: Floats, episode: EpisodeState) -> None:
    """Note the agents' actions, and write the latest ones.

    Reads: episode (action, steps).
    Writes: sent, episode (observation).
    """
    count, size = sent.shape[2], episode.action.shape[2]
    for w in worlds:
        for a in range(episode.action.shape[1]):
            newest = episode.steps[w, a]
            for c in range(size):
                # At the start, the action is the one for standing still.
                for k in range(count if newest == 0 else 1):
                    sent[w, a, (newest + k) % count, c] = episode.action[w, a, c]
                for k in range(count):
                    episode.observation[w, a, column + size * k + c] = np.float32(sent[w, a, (newest - k) % count, c])
