"""Progress: coming closer to the goal pays, moving away costs as much."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.engine import Shard, Simulation
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind, option
from irsim_gym.tasks.outcome import Outcome
from irsim_gym.tasks.rewards.geodesic import field_arrays, note_fields, pay_field_gain
from irsim_gym.tasks.state import EpisodeState
from irsim_gym.tasks.term import Role, Term
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


@kind
class Progress:
    """``weight`` times the way gained towards the goal in the step, over the world's diagonal.

    The way is measured to the goal that was next before the step, so that a change of goal costs nothing.
    """

    only_kernels: ClassVar[bool] = True
    role: ClassVar[Role] = "potential"
    outcome: ClassVar[Outcome] = Outcome.RUNNING
    needs_goal: ClassVar[bool] = True
    needs_ending: ClassVar[bool] = False

    weight: float = option(4.0, ge=0.0, meaning="Reward for a gain of one diagonal of the world.")
    potential: Literal["euclidean", "geodesic"] = option(
        "euclidean", meaning="The way: straight, or around everything that never moves, at the agent's reach."
    )
    cell: float = option(0.1, gt=0.0, unit="m", meaning="Geodesic: side of the cells in which ways are measured.")

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]]:
        """Return the memory: each agent's goal and its distance, one step ago."""
        shape = (simulation.n_worlds, len(agents))
        memory: dict[str, NDArray[Any]] = {"target": np.zeros((*shape, 2)), "potential": np.zeros(shape)}
        fields = field_arrays(simulation, len(agents), self.cell) if self.potential == "geodesic" else {}
        return memory | fields

    @staticmethod
    def begin(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
        """Note goals and distances."""
        if term.options.potential == "geodesic":
            note_fields(term, model, state, episode, shard)
        else:
            memory = term.arrays
            note(shard.worlds, term.agents, state, memory["target"], memory["potential"])

    def when(self, term: Term) -> str:
        """Return when and how much it pays."""
        way = "way around what never moves" if self.potential == "geodesic" else "straight way"
        return f"{self.weight:g} times the {way} gained towards the goal in the step, over the world's diagonal"

    @staticmethod
    def pay(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
        """Write the gain since the step before, and note where things are now."""
        if term.options.potential == "geodesic":
            pay_field_gain(term, model, state, shard, episode.reward_term)
            note_fields(term, model, state, episode, shard)
            return
        memory = term.arrays
        pay_gain(
            shard.worlds,
            term.agents,
            term.column,
            term.options.weight,
            model,
            state,
            episode,
            memory["target"],
            memory["potential"],
        )


@kernel
def distance(pose: Floats, target: Floats) -> float:
    """Return the distance from a pose to a point [m]."""
    dx, dy = target[0] - pose[0], target[1] - pose[1]
    return float(np.sqrt(dx * dx + dy * dy))


@kernel
def note(worlds: Ints, agents: Ints, state: WorldState, target: Floats, potential: Floats) -> None:
    """Write where each agent's goal is and how far away [m]."""
    for w in worlds:
        for a in range(agents.shape[0]):
            b = agents[a]
            target[w, a, 0], target[w, a, 1] = state.goal[w, b, 0], state.goal[w, b, 1]
            potential[w, a] = distance(state.pose[w, b], target[w, a])


@kernel
def pay_gain(
    worlds: Ints,
    agents: Ints,
    column: int,
    weight: float,
    model: WorldModel,
    state: WorldState,
    episode: EpisodeState,
    target: Floats,
    potential: Floats,
) -> None:
    """Write the weighted loss of distance to the noted goal, over the diagonal of ``bounds``; note what is new."""
    width, height = model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1]
    rate = weight / np.sqrt(width * width + height * height)
    for w in worlds:
        for a in range(agents.shape[0]):
            b = agents[a]
            gain = potential[w, a] - distance(state.pose[w, b], target[w, a])
            episode.reward_term[w, a, column] = rate * gain
            target[w, a, 0], target[w, a, 1] = state.goal[w, b, 0], state.goal[w, b, 1]
            potential[w, a] = distance(state.pose[w, b], target[w, a])
