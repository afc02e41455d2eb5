"""Collision: the penalty for touching another body."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.engine import Shard, Simulation
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind, option
from irsim_gym.tasks.outcome import Outcome
from irsim_gym.tasks.state import EpisodeState
from irsim_gym.tasks.term import Role, Term
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


@kind
class Collision:
    """Penalty ``-weight`` in the step in which the agent begins to touch another body."""

    role: ClassVar[Role] = "penalty"
    outcome: ClassVar[Outcome] = Outcome.COLLISION
    needs_goal: ClassVar[bool] = False
    needs_ending: ClassVar[bool] = False

    weight: float = option(4.0, ge=0.0, meaning="Penalty for a collision.")

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]]:
        """Return the memory of who was touching something one step ago, ``(n_worlds, n_agents)``."""
        return {"touching": np.zeros((simulation.n_worlds, len(agents)), np.bool_)}

    @staticmethod
    def begin(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
        """Forget; who touches something in the first step has begun to."""
        term.arrays["touching"][shard.worlds] = False

    @staticmethod
    def pay(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
        """Write the penalty."""
        pay_onset(
            shard.worlds,
            term.agents,
            term.column,
            -term.options.weight,
            state.collided,
            term.arrays["touching"],
            episode.reward_term,
        )


@kernel
def pay_onset(
    worlds: Ints, agents: Ints, column: int, amount: float, collided: Flags, touching: Flags, out: Floats
) -> None:
    """Write ``amount`` where a collision begins, and remember who collides."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(agents.shape[0]):
            now = collided[w, agents[a]]
            out[w, a, column] = amount if now and not touching[w, a] else 0.0
            touching[w, a] = now
