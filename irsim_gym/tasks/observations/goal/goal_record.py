"""Goal record: the memory of a Bug algorithm."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Floats, Ints, Model, Rays, Shard, State, Struct, kernel, kind, option
from irsim_gym.tasks.terms import Columns, EpisodeState, Mirrored, RobotValues, Simulation, Value, unchanged
from irsim_gym.tasks.terms.term import Bound, Needs, Term, forget


@dataclass
class Records(Struct):
    """The agents' smallest distances to their goals so far.

    Attributes:
        nearest: Minimum goal distance [m], shape ``(n_worlds, n_agents)``.
        since: Time of the minimum [s], shape ``(n_worlds, n_agents)``.
        target: The goal [m], shape ``(n_worlds, n_agents, 2)``.
    """

    nearest: Floats
    since: Floats
    target: Floats


@kind
class GoalRecord:
    """How much farther away the goal is than at the smallest distance so far, and the time since then.

    They are encoded as ``e / (e + near)`` and ``t / (t + soon)``. A policy without memory cannot tell whether it drives
    around an obstacle or back into the same pocket. With this number, a robot can leave a wall where it is nearer to
    the goal than ever before, and thus never drive in circles (Lumelsky & Stepanov 1987; Kamon & Rivlin 1997).
    """

    needs_goal: ClassVar[bool] = True
    needs: ClassVar[Needs] = ("odometry",)

    near: float = option(1.0, gt=0.0, unit="m", meaning="Distance beyond the record that reads 0.5.")
    soon: float = option(2.0, gt=0.0, unit="s", meaning="Time since the record that reads 0.5.")

    def arrays(self, simulation: Simulation, agents: Ints) -> Records:
        """Return the memory."""
        shape = (simulation.n_worlds, len(agents))
        return Records(np.zeros(shape), np.zeros(shape), np.zeros((*shape, 2)))

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the two elements."""
        return np.zeros(2, np.float32), np.ones(2, np.float32)

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns, which do not change."""
        return unchanged(2)

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Clear the record."""
        forget(term.arrays.nearest, np.inf, episode, shard)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        return [
            Columns("how much farther the goal is than at its nearest", f"e / (e + {self.near:g} m)"),
            Columns("time since it was at its nearest", f"t / (t + {self.soon:g} s)"),
        ]

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        graph, goal = robot.graph, robot.goal.columns(0, 2)
        d = robot.ways(goal.spread(1)).length(2)
        nearest, target = graph.state("record_nearest", np.array([np.inf])), graph.state("record_goal", np.zeros(2))
        since = graph.state("record_age", np.zeros(1))
        is_new = (d < nearest) | ((goal - target).spread(1).length(2) > 0.0)
        nearest, since = is_new.where(d, nearest), (~is_new).where(since + robot.elapsed, 0.0)
        for name, value in (("record_nearest", nearest), ("record_goal", goal), ("record_age", since)):
            graph.keep(name, value)
        both = graph.join([d - nearest, since])
        return (both / (both + np.array([self.near, self.soon]))).cast(np.float32)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Update the record and write the two elements."""
        write_record(shard.worlds, term.bound, term.arrays, state, episode)


@kernel
def write_record(worlds: Ints, term: Bound, records: Records, state: State, episode: EpisodeState) -> None:
    """Write the excess of the goal distance over the record and the time since; a new goal begins a new record.

    Reads: term (agents, column, options), records (nearest, since, target), state (goal, goal_distance, time).
    Writes: records (nearest, since, target), episode (observation).
    """
    options, column = term.options[0], term.column
    for w in worlds:
        for a in range(term.agents.shape[0]):
            b, target = term.agents[a], records.target[w, a]
            d, x, y = state.goal_distance[w, b], state.goal[w, b, 0], state.goal[w, b, 1]
            if d < records.nearest[w, a] or x != target[0] or y != target[1]:
                target[0], target[1] = x, y
                records.nearest[w, a], records.since[w, a] = d, state.time[w]
            excess, elapsed = d - records.nearest[w, a], state.time[w] - records.since[w, a]
            episode.observation[w, a, column] = np.float32(excess / (excess + options.near))
            episode.observation[w, a, column + 1] = np.float32(elapsed / (elapsed + options.soon))
