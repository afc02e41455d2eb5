"""Collision: the penalty for touching another body."""

from collections.abc import Iterable
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from irsim_gym.simulator.world.names import Flags, Floats, Ints, Model, Shard, State, kernel, kind, option
from irsim_gym.tasks.terms import EpisodeState, Simulation
from irsim_gym.tasks.terms.outcome import COLLISION, HitKind, Outcome
from irsim_gym.tasks.terms.term import RewardDefaults, Role, Term, forget


@kind
class Collision(RewardDefaults):
    """Penalty ``-weight`` in the step in which the agent begins to touch another body, or its episode ends by it."""

    role: ClassVar[Role] = "penalty"
    outcome: ClassVar[Outcome] = Outcome.COLLISION

    # Less than an arrival pays (5): where a collision costs much more, policies learn to wait in front of narrow
    # gaps. It is still more than all running costs of an episode, as the audit of rewards requires.
    weight: float = option(4.0, ge=0.0, meaning="Penalty for a collision.")
    robot: float | None = option(None, ge=0.0, meaning="Penalty for a collision with a robot; default: weight.")
    obstacle: float | None = option(None, ge=0.0, meaning="Penalty for a collision with an obstacle; default: weight.")
    map: float | None = option(None, ge=0.0, meaning="Penalty for a collision with the obstacle map; default: weight.")

    def least(self, bodies: Iterable[str] | None = None) -> float:
        """Return the smallest penalty for a collision with any body, or with some kinds (see ``collided``)."""
        kinds = list(HitKind)[1:] if bodies is None else [HitKind[name.upper()] for name in bodies]
        return min(self._amounts()[kind] for kind in kinds)

    def _amounts(self) -> tuple[float, ...]:
        """Return the penalties by HitKind."""
        robot, obstacle, cells = (self.weight if own is None else own for own in (self.robot, self.obstacle, self.map))
        return 0.0, obstacle, obstacle, robot, cells

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]]:
        """Return the penalties by HitKind, and flags of the agents that touched something one step ago."""
        touching = np.zeros((simulation.n_worlds, len(agents)), np.bool_)
        return {"touching": touching, "amounts": -np.array(self._amounts())}

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Clear the flags: a contact in the first step counts as new."""
        forget(term.arrays["touching"], False, episode, shard)

    def when(self, term: Term) -> str:
        """Return when and how much it pays, as text."""
        names = {"obstacle": "an obstacle", "robot": "a robot", "map": "the map"}
        special = [f"with {names[key]} -{getattr(self, key):g}" for key in names if getattr(self, key) is not None]
        return f"-{self.weight:g} in the step in which it begins to touch another body" + "".join(
            f"; {part}" for part in special
        )

    @staticmethod
    def pay(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the penalty."""
        pay_onset(
            shard.worlds, term.agents, term.column, term.arrays["amounts"], state, episode, term.arrays["touching"]
        )


@kernel
def pay_onset(
    worlds: Ints, agents: Ints, column: int, amounts: Floats, state: State, episode: EpisodeState, touching: Flags
) -> None:
    """Write the amount if a collision begins or ends the episode, and store who collides.

    Reads: state (collided), episode (hit_kind, outcome).
    Writes: episode (reward_term), touching.
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            now = state.collided[w, agents[a]]
            pays = now and (not touching[w, a] or episode.outcome[w, a] == COLLISION)
            episode.reward_term[w, a, column] = amounts[episode.hit_kind[w, a]] if pays else 0.0
            touching[w, a] = now
