"""Evaluation of policies on the levels of a split, with the reference policies."""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from irsim_gym.evaluation.levels.played import PlayedLevels, played_levels
from irsim_gym.evaluation.measures.metrics import summarize
from irsim_gym.evaluation.measures.optimum import Optima
from irsim_gym.evaluation.measures.team_metrics import summarize_teams
from irsim_gym.evaluation.measures.worst_levels import worst_of_policies
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.policies.policy import Policy
from irsim_gym.evaluation.policies.reference_policies import ALWAYS_SHOWN, TEAM_SHOWN
from irsim_gym.evaluation.protocol.progress_bars import progress_bar
from irsim_gym.evaluation.protocol.protocol import evaluate, optima_of
from irsim_gym.evaluation.protocol.tables import legend, table_text, worst_table, write_json, write_text
from irsim_gym.evaluation.protocol.team_tables import figure_tables, write_levels, write_rows
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.requests.episode_setup import conditions, team_conditions
from irsim_gym.evaluation.requests.fitting import check_policies, fitting_references, observed_by, report_perceptions
from irsim_gym.evaluation.requests.machine import machine
from irsim_gym.evaluation.requests.methods import Sources, by_method, names_of_policies
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import load_policies, load_policy
from irsim_gym.tasks import Episodes

WORLDS = 256
"""Default number of worlds that are stepped together."""


@dataclass(frozen=True)
class Evaluation:
    """Results of several policies on the same levels.

    Attributes:
        scenario: Name of the scenario, with the values of its parameters.
        split: Split of the levels.
        rows: An ``EpisodeRow`` of each level for each policy; of a team a ``TeamRow``.
        summaries: Summary of each policy, in the same order; of a team a ``TeamSummary``.
        level_set: Hash and certificate of the levels.
        seeds: Names of the policies of each method that has several.
        observes: Names of the observations of each policy that uses observations.
    """

    scenario: str
    split: str
    rows: dict[str, list[Any]]
    summaries: list[Any]
    level_set: PlayedLevels
    seeds: dict[str, list[str]]
    observes: dict[str, list[str]] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """The scenario, the number of robots in a team, and the levels."""
        agents = self.summaries[0].agents if isinstance(self, TeamEvaluation) else 0
        whose = "" if not agents else " 1 agent," if agents == 1 else f" {agents} agents,"
        return f"{self.scenario}:{whose} {self.level_set.count:,} {self.split} levels, {self.level_set}"

    @property
    def tables(self) -> list[Table]:
        """Figures of each policy, success on the worst levels, and success by difficulty where a certificate exists."""
        worst = worst_table(self.worst, self.seeds)
        return [*figure_tables(self.summaries, self.title), worst, *self.level_set.tables(self.solved)]

    @property
    def solved(self) -> dict[str, list[bool]]:
        """Success in each level, for each policy; of a team, whether all robots arrived."""
        return {name: [row.is_success for row in rows] for name, rows in self.rows.items()}

    @property
    def worst(self) -> dict[str, dict[str, float]]:
        """Success on the worst 5 % and 1 % of levels, for each policy and each method of several seeds.

        See ``irsim_gym.evaluation.measures.worst_levels``.
        """
        return worst_of_policies(self.solved, self.seeds)

    @property
    def legend(self) -> str:
        """What columns of the tables mean, one line each."""
        name = "cooperative_success" if isinstance(self, TeamEvaluation) else "success"
        return legend(self.tables, [getattr(summary, name) for summary in self.summaries])

    def __str__(self) -> str:
        return "\n".join([*map(table_text, self.tables), self.legend + "\n"])


class TeamEvaluation(Evaluation):
    """Results of several policies that each drove all robots."""


def evaluate_policies(
    request: ScenarioRequest,
    sources: Sources,
    *,
    levels: int = 1000,
    split: str = "test",
    n_worlds: int = WORLDS,
    references: bool = True,
    folder: Path | None = None,
) -> Evaluation:
    """Evaluate policies of single robots or of teams, and write tables and rows; see ``irsim_gym.evaluate``.

    A policy that records the observations and actions of its training keeps them. All others observe and act as the
    task defines. Everything else follows from the task for all policies. All robots of a team share a policy, and
    reference policies that cannot drive all of them are left out, with a message.
    """
    chosen, seeds, worlds = prepare(request, sources, min(n_worlds, levels), references=references)
    evaluation = play(chosen, seeds, worlds, levels, split, team=request.team)
    if folder is not None:
        write_results(folder, evaluation, worlds.episodes)
    return evaluation


def prepare(
    request: ScenarioRequest, sources: Sources, n_worlds: int, *, references: bool = False
) -> tuple[dict[str, Policy], dict[str, list[str]], Perceived]:
    """Return policies by name, the names of each method that has several, and worlds that all of them can play in."""
    worlds = Perceived(request.episodes(max(1, n_worlds)))
    chosen, seeds = _named_policies(sources)
    if references:
        names = [name for name in (TEAM_SHOWN if request.team else ALWAYS_SHOWN) if name not in chosen]
        if request.team:
            chosen |= fitting_references(names, worlds.episodes, sys.stderr)
        else:
            chosen |= {name: load_policy(name) for name in names}
    check_policies(chosen, worlds)
    report_perceptions(chosen, worlds)
    return chosen, seeds, worlds


def write_results(folder: Path, evaluation: Evaluation, episodes: Episodes, **more: object) -> dict[str, object]:
    """Write the rows, the summaries and the tables of an evaluation, and return what ``summary.json`` holds.

    Args:
        episodes: The worlds in which it was played, for its conditions.
        **more: Further entries of ``summary.json``.
    """
    write_rows(folder / "episodes.csv", evaluation.rows)
    is_team = isinstance(evaluation, TeamEvaluation)
    if is_team:
        write_levels(folder / "levels.csv", evaluation.rows)
    named = (team_conditions if is_team else conditions)(episodes, evaluation.split, evaluation.level_set.count)
    named |= evaluation.level_set.conditions()
    figures = {"conditions": named, "machine": machine(), "policies": evaluation.summaries, "worst": evaluation.worst}
    summary = {**more, **figures, "observes": evaluation.observes}
    write_json(folder / "summary.json", summary)
    write_text(folder / "table.txt", str(evaluation))
    return summary


def _named_policies(sources: Sources) -> tuple[dict[str, Policy], dict[str, list[str]]]:
    """Load policies; return them by name, and the names of the policies of each method that has several."""
    methods = by_method(sources)
    names = names_of_policies(methods)
    loaded = load_policies([source for several in methods.values() for source in several])
    chosen = dict(zip((name for several in names.values() for name in several), loaded, strict=True))
    return chosen, {method: several for method, several in names.items() if len(several) > 1}


def play(
    policies: Mapping[str, Policy],
    seeds: dict[str, list[str]],
    worlds: Perceived,
    levels: int,
    split: str,
    *,
    team: bool,
    console: Console | None = None,
    optima: Optima | None = None,
) -> Evaluation:
    """Play the same levels with several policies, and show a progress bar.

    Args:
        seeds: Names of the policies of each method that has several.
        levels: Number of levels of the split, from level 0.
        team: Whether each policy drives all robots.
        console: Console of the progress bar; None for standard error.
        optima: Optima of earlier evaluations of the same levels; new ones are added.
    """
    optima, rows, simulation = optima_of(split, optima), dict[str, list[Any]](), worlds.episodes.simulation
    evaluation: Any = evaluate_team if team else evaluate
    with progress_bar(console) as bar:
        for name, policy in policies.items():
            advance = partial(bar.advance, bar.add_task(name, total=levels))
            rows[name] = evaluation(policy, worlds.of(policy), levels, split, optima=optima, on_episodes=advance)
    summaries: list[Any] = summarize_teams(rows) if team else [summarize(name, rows[name]) for name in rows]
    level_set, observes = played_levels(simulation, split, levels), observed_by(policies, worlds)
    kind = TeamEvaluation if team else Evaluation
    return kind(simulation.scenario.label, split, rows, summaries, level_set, seeds, observes)
