"""Progress: the reward for approaching the goal, and the equal cost of moving away."""

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from irsim_gym.simulator.world.names import Floats, Ints, Model, Shard, State, Struct, kernel, kind, option
from irsim_gym.tasks.rewards.geodesic import Fields, note_fields, pay_field_gain
from irsim_gym.tasks.terms import Bound, EpisodeState, RewardDefaults, Role, Simulation, Term, diagonal


@dataclass
class Potentials(Struct):
    """The agents' goals one step ago, with their distances.

    Attributes:
        target: The goals [m], shape ``(n_worlds, n_agents, 2)``.
        distance: Their distances [m], shape ``(n_worlds, n_agents)``.
    """

    target: Floats
    distance: Floats


@kind
class Progress(RewardDefaults):
    """``weight`` times the progress towards the goal in the step, divided by the world's diagonal.

    Progress is measured to the goal before the step, so that a change of goal costs nothing.
    """

    role: ClassVar[Role] = "potential"
    needs_goal: ClassVar[bool] = True

    weight: float = option(4.0, ge=0.0, meaning="Reward for progress of one diagonal of the world.")
    potential: Literal["euclidean", "geodesic"] = option(
        "euclidean", meaning="Distance to the goal: straight, or around all that never moves, with room."
    )
    cell: float = option(0.1, gt=0.0, unit="m", meaning="With geodesic, the cell size for distances.")

    def arrays(self, simulation: Simulation, agents: Ints) -> Potentials | Fields:
        """Return the memory: each agent's goal and its distance, one step ago."""
        if self.potential == "geodesic":
            return Fields.over(simulation, len(agents), self.cell)
        shape = (simulation.n_worlds, len(agents))
        return Potentials(np.zeros((*shape, 2)), np.zeros(shape))

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Store goals and distances."""
        if term.options.potential == "geodesic":
            note_fields(term, model, state, episode, shard)
        else:
            note(shard.worlds, term.agents, term.arrays, state)

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        way = "way around what never moves" if self.potential == "geodesic" else "straight way"
        return f"{self.weight:g} times the {way} gained towards the goal in the step, over the world's diagonal"

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the gain since the previous step, and store goals and distances."""
        if term.options.potential == "geodesic":
            pay_field_gain(shard.worlds, term.bound, term.arrays, model, state, episode)
            note_fields(term, model, state, episode, shard)
        else:
            pay_gain(shard.worlds, term.bound, term.arrays, model, state, episode)


@kernel
def distance(pose: Floats, target: Floats) -> float:
    """Return the distance from a pose to a point [m]."""
    dx, dy = target[0] - pose[0], target[1] - pose[1]
    return float(np.sqrt(dx * dx + dy * dy))


@kernel
def note(worlds: Ints, agents: Ints, memory: Potentials, state: State) -> None:
    """Store each agent's goal and its distance [m].

    Reads: memory (target), state (goal, pose).
    Writes: memory (distance, target).
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            b, target = agents[a], memory.target[w, a]
            target[0], target[1] = state.goal[w, b, 0], state.goal[w, b, 1]
            memory.distance[w, a] = distance(state.pose[w, b], target)


@kernel
def pay_gain(worlds: Ints, term: Bound, memory: Potentials, model: Model, state: State, episode: EpisodeState) -> None:
    """Write the weighted decrease of distance to the stored goal, over the diagonal of ``bounds``; store the new goal.

    Reads: term (agents, column, options), memory (distance, target), model (bounds), state (goal, pose).
    Writes: memory (distance, target), episode (reward_term).
    """
    rate = term.options[0].weight / diagonal(model.bounds)
    for w in worlds:
        for a in range(term.agents.shape[0]):
            b, target = term.agents[a], memory.target[w, a]
            gain = memory.distance[w, a] - distance(state.pose[w, b], target)
            episode.reward_term[w, a, term.column] = rate * gain
            target[0], target[1] = state.goal[w, b, 0], state.goal[w, b, 1]
            memory.distance[w, a] = distance(state.pose[w, b], target)
