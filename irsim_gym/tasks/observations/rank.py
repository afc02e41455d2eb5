"""Rank: the agent's number in its team."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from irsim_gym.arraytypes import Ints, Rays
from irsim_gym.engine import Shard
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.mirrored import Mirrored, unchanged
from irsim_gym.tasks.term import Term
from irsim_gym.tasks.words import Columns
from irsim_gym.world.model import Model
from irsim_gym.world.state import State


@kind
class TeamRank:
    """The agent's place among the agents of its world, from 0 for the first to 1 for the last; 0 for a single one.

    Agents with one policy that see the same do the same, and may give way to each other for ever. Their numbers let
    them differ: one of two waits for longer.
    """

    only_kernels: ClassVar[bool] = True
    needs_goal: ClassVar[bool] = False
    needs_scan: ClassVar[bool] = False

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the element."""
        return np.zeros(1, np.float32), np.ones(1, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> Sequence[Columns]:
        """Return the meaning of the column."""
        return [Columns("its place among the agents", "0 for the first, 1 for the last")]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the column, which does not change."""
        return unchanged(1)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the element."""
        write_ranks(shard.worlds, term.column, episode)


@kernel
def write_ranks(worlds: Ints, column: int, episode: EpisodeState) -> None:
    """Write the place of each agent.

    Reads: episode (outcome).
    Writes: episode (observation).
    """
    n_agents = episode.outcome.shape[1]
    for w in worlds:
        for a in range(n_agents):
            episode.observation[w, a, column] = np.float32(a / (n_agents - 1) if n_agents > 1 else 0.0)
