"""Evaluation of policies on the levels of a split, with the reference policies."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from irsim_gym.evaluation.behavior_policies import BehaviorPolicy, UnfitBehaviorError
from irsim_gym.evaluation.metrics import EpisodeRow, Rate, Summary, summarize
from irsim_gym.evaluation.optimum import Optima
from irsim_gym.evaluation.perception import Perceived
from irsim_gym.evaluation.policy import Policy
from irsim_gym.evaluation.progress_bars import progress_bar
from irsim_gym.evaluation.protocol import evaluate
from irsim_gym.evaluation.reference_policies import ALWAYS_SHOWN, TEAM_SHOWN
from irsim_gym.evaluation.tables import legend, percent, table_text, worst_table, write_json, write_text
from irsim_gym.evaluation.team_metrics import summarize_teams
from irsim_gym.evaluation.team_tables import figure_tables, write_levels, write_rows
from irsim_gym.evaluation.teams import evaluate_team
from irsim_gym.evaluation.trajectories import Watcher
from irsim_gym.evaluation.worst_levels import worst_of_policies
from irsim_gym.levels.played import PlayedLevels, played_levels
from irsim_gym.tasks import Episodes
from irsim_gym.training.episode_setup import conditions, team_conditions
from irsim_gym.training.evaluate_teams import TeamEvaluation
from irsim_gym.training.fitting import check_policies, observed_by, report_perceptions
from irsim_gym.training.machine import machine
from irsim_gym.training.methods import Sources, by_method, names_of_policies
from irsim_gym.training.policies import load_policies, load_policy
from irsim_gym.training.scenario_request import ScenarioRequest
from irsim_gym.training.trajectory_figures import TrajectoryFigure

WORLDS = 128
"""Default number of worlds that are stepped together."""


@dataclass(frozen=True)
class Evaluation:
    """Results of several policies on the same levels.

    Attributes:
        scenario: Name of the scenario, with the values of its parameters.
        split: Split of the levels.
        rows: Episodes of each policy.
        summaries: Summary of each policy, in the same order.
        level_set: Hash and certificate of the levels.
        seeds: Names of the policies of each method that has several.
        observes: Names of the observations of each policy that uses observations.
    """

    scenario: str
    split: str
    rows: dict[str, list[EpisodeRow]]
    summaries: list[Summary]
    level_set: PlayedLevels
    seeds: dict[str, list[str]]
    observes: dict[str, list[str]] = field(default_factory=dict)

    @property
    def tables(self) -> list[Table]:
        """Tables of the summaries, of the worst levels, and, if the levels are certified, of success by difficulty."""
        title = f"{self.scenario}: {self.summaries[0].episodes:,} {self.split} levels, {self.level_set}"
        worst = worst_table(self.worst, self.seeds)
        return [*figure_tables(self.summaries, title), worst, *self.level_set.tables(self.solved)]

    @property
    def solved(self) -> dict[str, list[bool]]:
        """Success in each level, for each policy."""
        return {name: [row.outcome == "success" for row in rows] for name, rows in self.rows.items()}

    @property
    def worst(self) -> dict[str, dict[str, float]]:
        """Success on the worst 5 % and 1 % of levels, for each policy and each method of several seeds.

        See ``irsim_gym.evaluation.worst_levels``.
        """
        return worst_of_policies(self.solved, self.seeds)

    @property
    def legend(self) -> str:
        """What columns of the tables mean, one line each."""
        return legend(self.tables, [summary.success for summary in self.summaries])

    def __str__(self) -> str:
        return "\n".join([*map(table_text, self.tables), self.legend + "\n"])


def evaluate_policies(
    asked: ScenarioRequest,
    sources: Sources,
    *,
    levels: int = 1000,
    split: str = "test",
    n_worlds: int = WORLDS,
    references: bool = True,
    folder: Path | None = None,
) -> Evaluation | TeamEvaluation:
    """Evaluate policies of single robots or of teams, and write tables, rows and figures; see ``irsim_gym.evaluate``.

    A policy that records the observations and actions of its training keeps them. All others observe and act as the
    task defines. Everything else follows from the task for all policies. All robots of a team share a policy, and
    reference policies that cannot drive all of them are left out, with a message.
    """
    episodes = asked.episodes(max(1, min(n_worlds, levels)))
    worlds = Perceived(episodes)
    chosen, seeds = _named_policies(sources)
    if references:
        chosen |= _references(chosen, episodes, team=asked.team)
    figure = None if folder is None else TrajectoryFigure(episodes)
    check_policies(chosen, worlds)
    report_perceptions(chosen, worlds)
    follow: Callable[[str], Watcher | None] = (lambda name: None) if figure is None else figure.follow
    rows = dict(play_policies(chosen, worlds, levels, split, team=asked.team, follow=follow))
    played = played_levels(episodes.simulation, split, levels)
    label, observes = episodes.simulation.scenario.label, observed_by(chosen, worlds)
    found: Evaluation | TeamEvaluation
    if asked.team:
        found = TeamEvaluation(label, split, rows, summarize_teams(rows), played, seeds, observes)
    else:
        summaries = [summarize(name, rows[name]) for name in rows]
        found = Evaluation(label, split, rows, summaries, played, seeds, observes)
    if folder is not None and figure is not None:
        _write(folder, found, (team_conditions if asked.team else conditions)(episodes, split, levels))
        robots = f" {episodes.n_agents} robots," if asked.team else ""
        figure.draw(folder, f"{label}:{robots} {levels:,} {split} levels", _arrivals(found), levels)
    return found


def _write(folder: Path, found: Evaluation | TeamEvaluation, named: Mapping[str, object]) -> None:
    """Write the rows, the summaries and the tables of an evaluation; ``named`` are its conditions."""
    write_rows(folder / "episodes.csv", found.rows)
    if isinstance(found, TeamEvaluation):
        write_levels(folder / "levels.csv", found.rows)
    named = {**named, **found.level_set.conditions()}
    figures = {"conditions": named, "machine": machine(), "policies": found.summaries, "worst": found.worst}
    write_json(folder / "summary.json", {**figures, "observes": found.observes})
    write_text(folder / "table.txt", str(found))


def _arrivals(found: Evaluation | TeamEvaluation) -> dict[str, str]:
    """Return a text about the success of each policy."""
    if isinstance(found, Evaluation):
        return {each.policy: f"{_rate_text(each.success)} arrive" for each in found.summaries}
    return {
        each.policy: f"all arrive in {_rate_text(each.cooperative_success)} of the levels, "
        f"{percent(each.individual_success)} % of the robots"
        for each in found.summaries
    }


def _rate_text(share: Rate) -> str:
    """Return a share with its confidence interval, in percent."""
    return f"{percent(share)} % ({100.0 * share.low:.1f}\N{EN DASH}{100.0 * share.high:.1f})"


def _named_policies(sources: Sources) -> tuple[dict[str, Policy], dict[str, list[str]]]:
    """Load policies; return them by name, and the names of the policies of each method that has several."""
    methods = by_method(sources)
    names = names_of_policies(methods)
    loaded = load_policies([source for several in methods.values() for source in several])
    chosen = dict(zip((name for several in names.values() for name in several), loaded, strict=True))
    return chosen, {method: several for method, several in names.items() if len(several) > 1}


def _references(chosen: Mapping[str, Policy], episodes: Episodes, *, team: bool) -> dict[str, Policy]:
    """Return the reference policies that are missing; for a team, say which ones cannot drive all robots."""
    found = {}
    for name in (name for name in (TEAM_SHOWN if team else ALWAYS_SHOWN) if name not in chosen):
        policy = load_policy(name)
        try:
            if team and isinstance(policy, BehaviorPolicy):
                policy.check(episodes)
            found[name] = policy
        except UnfitBehaviorError as problem:
            print(f"without {name}: {problem}", file=sys.stderr)
    return found


def play_policies(
    policies: Mapping[str, Policy],
    worlds: Perceived,
    levels: int,
    split: str,
    *,
    team: bool,
    follow: Callable[[str], Watcher | None] = lambda name: None,
    console: Console | None = None,
) -> Iterator[tuple[str, list[Any]]]:
    """Play the same levels with several policies, and show a progress bar; yield the rows of each when it is done.

    Args:
        levels: Number of levels of the split, from level 0.
        team: Whether each policy drives all robots.
        follow: Returns what observes the steps of a policy, by its name.
        console: Console of the progress bar; None for standard error.
    """
    optima = Optima(split)
    evaluation: Any = evaluate_team if team else evaluate
    with progress_bar(console) as bar:
        for name, policy in policies.items():
            line = bar.add_task(name, total=levels)
            advance = partial(bar.advance, line)
            how: dict[str, Any] = {"optima": optima, "on_episodes": advance, "watcher": follow(name)}
            yield name, evaluation(policy, worlds.of(policy), levels, split, **how)
