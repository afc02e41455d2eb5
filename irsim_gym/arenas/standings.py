"""The comparison of an arena's policies: figures, differences, success by difficulty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich.table import Table

from irsim_gym.arenas.board import Board
from irsim_gym.arenas.crossplay import Meeting, meetings_table
from irsim_gym.arenas.strata import PEERS, Stratum, strata_of_peers, strata_of_quarters
from irsim_gym.evaluation.metrics import Summary, summarize
from irsim_gym.evaluation.paired import PairedComparison, compare_pairs
from irsim_gym.evaluation.tables import summary_table
from irsim_gym.evaluation.team_metrics import TeamSummary, summarize_teams
from irsim_gym.evaluation.team_tables import compared_table, team_table
from irsim_gym.levels.played import PlayedLevels


@dataclass(frozen=True)
class Standings:
    """The comparison of an arena's policies.

    Attributes:
        summaries: Figures of each policy; a ``TeamSummary`` for teams.
        pairs: Comparisons of each policy with each later one.
        strata_by: How the difficulty of levels is measured.
        strata: Success by difficulty, the easiest levels first.
        meetings: Results of each policy with each partner; empty without cross-play.
        level_set: The levels.
    """

    summaries: list[Summary] | list[TeamSummary]
    pairs: list[PairedComparison]
    strata_by: str
    strata: list[Stratum]
    meetings: list[Meeting]
    level_set: PlayedLevels

    def figures(self) -> dict[str, object]:
        """Return all figures by name, for a file."""
        strata = {"by": self.strata_by, "policies": [each.policy for each in self.summaries], "strata": self.strata}
        figures: dict[str, object] = {"policies": self.summaries, "pairs": self.pairs, "difficulty": strata}
        return {**figures, "meetings": self.meetings} if self.meetings else figures

    def tables(self, title: str) -> list[Table]:
        """Return the tables of figures for a terminal."""
        first = self.summaries[0]
        if isinstance(first, Summary):
            return [summary_table(self.summaries, title)]  # type: ignore[arg-type]
        compared = compared_table(self.summaries)  # type: ignore[arg-type]
        found = [team_table(self.summaries, title), *([] if compared is None else [compared])]  # type: ignore[arg-type]
        return [*found, meetings_table(self.meetings)] if self.meetings else found


def stand(
    rows: Mapping[str, Sequence[Any]],
    policies: Sequence[str],
    *,
    team: bool,
    meetings: list[Meeting],
    level_set: PlayedLevels,
) -> Standings:
    """Compare policies.

    Args:
        rows: Episodes (levels for teams) by policy; may also hold those of arrangements of two policies.
        team: Whether they drove teams.
        meetings: Results of each policy with each partner.
        level_set: The levels, and their certificate if they have one.
    """
    own = {policy: rows[policy] for policy in policies}
    board = Board.of(own)
    summaries = summarize_teams(own) if team else [summarize(policy, episodes) for policy, episodes in own.items()]
    certificate, quarters = level_set.certificate, level_set.quarters
    if certificate is None or quarters is None:
        by, strata = PEERS, strata_of_peers(board)
    else:
        by = f"by how many of {', '.join(certificate.policies)} fail, in quarters"
        strata = strata_of_quarters(board, quarters)
    return Standings(summaries, compare_pairs(policies, board.success, board.spl), by, strata, meetings, level_set)
