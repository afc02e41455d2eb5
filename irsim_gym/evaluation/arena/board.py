"""The results of policies on levels, from which all comparisons are made."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Floats, Ints
from irsim_gym.evaluation.measures.metrics import OUTCOMES, EpisodeRow, mean
from irsim_gym.evaluation.measures.team_metrics import TeamRow

WORST_FIRST = ("collision", "left_world", "deadlock", "misplaced", "timeout", "success")
"""Outcome of a team in a level: the first of these that one of its agents had."""

Row = EpisodeRow | TeamRow


@dataclass(frozen=True)
class Board:
    """The results of several policies on the same levels.

    Attributes:
        policies: Their names.
        levels: The levels, ``(n_levels,)``.
        outcome: Index in ``OUTCOMES``, ``(n_policies, n_levels)``; for a team, that of the agent that fared worst.
        arrived: Number of agents that arrived, ``(n_policies, n_levels)``.
        steps: Duration [steps], for a team that of its longest episode, ``(n_policies, n_levels)``.
        time: Duration [s], likewise.
        spl: Success weighted by path length, for a team the mean over its agents, ``(n_policies, n_levels)``.
        agents: Number of agents.
    """

    policies: tuple[str, ...]
    levels: Ints
    outcome: NDArray[np.int8]
    arrived: Ints
    steps: Ints
    time: Floats
    spl: Floats
    agents: int

    @classmethod
    def of(cls, rows: Mapping[str, Sequence[Row]]) -> Board:
        """Make a board from the rows of policies that all played the same levels, in the same order."""
        agents_by_policy = {policy: [_agents(row) for row in policy_rows] for policy, policy_rows in rows.items()}
        levels = [tuple(row.level for row in policy_rows) for policy_rows in rows.values()]
        assert len(set(levels)) == 1, "all policies must have played the same levels"

        def table(read: Callable[[tuple[EpisodeRow, ...]], float]) -> list[list[float]]:
            return [[read(agents) for agents in policy_agents] for policy_agents in agents_by_policy.values()]

        return cls(
            policies=tuple(rows),
            levels=np.array(levels[0], np.int64),
            outcome=np.array(table(_outcome), np.int8),
            arrived=np.array(table(lambda agents: sum(row.outcome == "success" for row in agents)), np.int64),
            steps=np.array(table(lambda agents: max(row.steps for row in agents)), np.int64),
            time=np.array(table(lambda agents: max(row.time for row in agents)), np.float64),
            spl=np.array(table(lambda agents: mean([row.spl for row in agents])), np.float64),
            agents=len(next(iter(agents_by_policy.values()))[0]),
        )

    @property
    def success(self) -> Flags:
        """Whether all agents arrived, ``(n_policies, n_levels)``."""
        return np.asarray(self.outcome == OUTCOMES.index("success"))


def _agents(row: Row) -> tuple[EpisodeRow, ...]:
    """Return the episodes of all agents."""
    return tuple(agent.episode for agent in row.agents) if isinstance(row, TeamRow) else (row,)


def _outcome(agents: Sequence[EpisodeRow]) -> int:
    """Return the index of a level's outcome."""
    seen = {row.outcome for row in agents}
    return OUTCOMES.index(next(outcome for outcome in WORST_FIRST if outcome in seen))
