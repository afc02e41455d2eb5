"""What the results of an arena say: figures, differences, easy and hard levels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich.table import Table

from irsim_gym.arenas.board import Board
from irsim_gym.arenas.crossplay import Meeting
from irsim_gym.arenas.strata import PEERS, QUARTILES, Stratum, strata_of_difficulty, strata_of_peers
from irsim_gym.arraytypes import Floats
from irsim_gym.evaluation.metrics import Summary, summarize
from irsim_gym.evaluation.paired import PairedComparison, compare_pairs
from irsim_gym.evaluation.tables import summary_table
from irsim_gym.evaluation.team_metrics import TeamSummary, summarize_teams
from irsim_gym.evaluation.team_tables import compared_table, team_table


@dataclass(frozen=True)
class Standings:
    """What is compared of the policies of an arena.

    Attributes:
        summaries: Figures of each policy; of teams a ``TeamSummary``.
        pairs: Each policy beside each one behind it.
        strata_by: How levels are told to be easy or hard.
        strata: Success on them, the easiest first.
        meetings: How each policy fares among each; empty without cross-play.
    """

    summaries: list[Summary] | list[TeamSummary]
    pairs: list[PairedComparison]
    strata_by: str
    strata: list[Stratum]
    meetings: list[Meeting]

    def figures(self) -> dict[str, object]:
        """Return all of it by name, for a file."""
        strata = {"by": self.strata_by, "policies": [each.policy for each in self.summaries], "strata": self.strata}
        figures: dict[str, object] = {"policies": self.summaries, "pairs": self.pairs, "difficulty": strata}
        return {**figures, "meetings": self.meetings} if self.meetings else figures

    def tables(self, title: str) -> list[Table]:
        """Return the tables of figures for a terminal."""
        first = self.summaries[0]
        if isinstance(first, Summary):
            return [summary_table(self.summaries, title)]  # type: ignore[arg-type]
        compared = compared_table(self.summaries)  # type: ignore[arg-type]
        return [team_table(self.summaries, title), *([] if compared is None else [compared])]  # type: ignore[arg-type]


def stand(
    rows: Mapping[str, Sequence[Any]],
    policies: Sequence[str],
    *,
    team: bool,
    meetings: list[Meeting],
    difficulty: Floats | None = None,
) -> Standings:
    """Compare policies.

    Args:
        rows: Episodes, of teams levels, by policy, and perhaps by arrangement of two.
        policies: The policies.
        team: They drove teams.
        meetings: How each fares among each.
        difficulty: Of each level; None where no level set tells it.
    """
    own = {policy: rows[policy] for policy in policies}
    board = Board.of(own)
    summaries = summarize_teams(own) if team else [summarize(policy, episodes) for policy, episodes in own.items()]
    by = PEERS if difficulty is None else QUARTILES
    strata = strata_of_peers(board) if difficulty is None else strata_of_difficulty(board, difficulty)
    return Standings(summaries, compare_pairs(policies, board.success, board.spl), by, strata, meetings)
