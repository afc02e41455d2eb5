"""Collided: the agent touches another body."""

from typing import ClassVar, Literal

import numpy as np

from irsim_gym.simulator.world.names import Flags, Ints
from irsim_gym.tasks.terms import EpisodeState, HitKind, Model, Outcome, Shard, State, Term, kernel, kind, option

Touched = Literal["obstacle", "moving_obstacle", "robot", "map"]


@kind
class Collided:
    """End with failure when the agent touches another body.

    If it touches several bodies in the same step, the first one in the file counts.
    """

    outcome: ClassVar[Outcome] = Outcome.COLLISION
    needs_goal: ClassVar[bool] = False

    bodies: tuple[Touched, ...] = option(
        ("obstacle", "moving_obstacle", "robot", "map"),
        min_length=1,
        meaning="Bodies that end the episode: obstacle (a standing one), moving_obstacle, robot, map.",
        consequence="If collisions do not end the episode, a robot in collision mode stop may stay stuck for the "
        "whole episode.",
    )

    def arrays(self, simulation: object, agents: Ints) -> dict[str, Flags]:
        """Return flags of the kinds of bodies that count, by HitKind."""
        counts = np.zeros(len(HitKind), np.bool_)
        counts[[HitKind[name.upper()] for name in self.bodies]] = True
        return {"counts": counts}

    def when(self, term: Term) -> str:
        """Return the condition, as text."""
        names = {"obstacle": "a standing obstacle", "moving_obstacle": "one that moves", "robot": "a robot"}
        return f"it touches {', '.join(names.get(name, 'the map') for name in self.bodies)}"

    @staticmethod
    def ends(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the flag."""
        find_hits(shard.worlds, term.agents, term.column, term.arrays["counts"], state, episode)


@kernel
def find_hits(worlds: Ints, agents: Ints, column: int, counts: Flags, state: State, episode: EpisodeState) -> None:
    """Write a column of ``ending``: whether the agent touches a body of a kind that counts.

    Reads: state (collided), episode (hit_kind).
    Writes: episode (ending).
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            episode.ending[w, a, column] = state.collided[w, agents[a]] and counts[episode.hit_kind[w, a]]
