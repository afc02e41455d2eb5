"""Results of policies that drive whole teams on the levels of a split."""

from __future__ import annotations

from dataclasses import dataclass, field

from rich.table import Table

from irsim_gym.evaluation.tables import legend, table_text, worst_table
from irsim_gym.evaluation.team_metrics import TeamRow, TeamSummary
from irsim_gym.evaluation.team_tables import figure_tables
from irsim_gym.evaluation.worst_levels import worst_of_policies
from irsim_gym.levels.played import PlayedLevels


@dataclass(frozen=True)
class TeamEvaluation:
    """Results of several team policies on the same levels.

    Attributes:
        scenario: Name of the scenario, with the values of its parameters.
        split: Split of the levels.
        rows: Levels of each policy.
        summaries: Summary of each policy, in the same order.
        level_set: Hash and certificate of the levels.
        seeds: Names of the policies of each method that has several.
        observes: Names of the observations of each policy that uses observations.
    """

    scenario: str
    split: str
    rows: dict[str, list[TeamRow]]
    summaries: list[TeamSummary]
    level_set: PlayedLevels
    seeds: dict[str, list[str]]
    observes: dict[str, list[str]] = field(default_factory=dict)

    @property
    def tables(self) -> list[Table]:
        """Tables of the summaries, of compared extra times, of the worst levels, and of success by difficulty."""
        first = self.summaries[0]
        whose = "1 agent" if first.agents == 1 else f"{first.agents} agents"
        title = f"{self.scenario}: {whose}, {first.levels:,} {self.split} levels, {self.level_set}"
        worst = worst_table(self.worst, self.seeds)
        return [*figure_tables(self.summaries, title), worst, *self.level_set.tables(self.solved)]

    @property
    def solved(self) -> dict[str, list[bool]]:
        """Success of the whole team in each level, for each policy."""
        return {name: [row.is_success for row in rows] for name, rows in self.rows.items()}

    @property
    def worst(self) -> dict[str, dict[str, float]]:
        """Success on the worst 5 % and 1 % of levels, for each policy and each method of several seeds.

        See ``irsim_gym.evaluation.worst_levels``.
        """
        return worst_of_policies(self.solved, self.seeds)

    @property
    def legend(self) -> str:
        """What columns of the tables mean, one line each."""
        return legend(self.tables, [summary.cooperative_success for summary in self.summaries])

    def __str__(self) -> str:
        return "\n".join([*map(table_text, self.tables), self.legend + "\n"])
