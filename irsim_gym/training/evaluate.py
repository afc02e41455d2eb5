"""Evaluation of policies on the levels of a split, with the reference policies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from irsim_gym.envs.worlds import ScenarioSource, TaskSource
from irsim_gym.evaluation.metrics import EpisodeRow, Rate, Summary, summarize
from irsim_gym.evaluation.optimum import Optima
from irsim_gym.evaluation.perception import Perceived
from irsim_gym.evaluation.policy import Policy
from irsim_gym.evaluation.protocol import evaluate
from irsim_gym.evaluation.reference_policies import ALWAYS_SHOWN
from irsim_gym.evaluation.tables import (
    percent,
    summary_table,
    table_text,
    worst_table,
    write_episodes,
    write_json,
    write_text,
)
from irsim_gym.evaluation.worst_levels import worst_of_policies
from irsim_gym.levels.played import PlayedLevels, played_levels
from irsim_gym.training.episode_setup import conditions, make_episodes
from irsim_gym.training.fitting import check_policies, observed_by, report_perceptions
from irsim_gym.training.methods import Sources, by_method, names_of_policies
from irsim_gym.training.policies import load_policies, load_policy
from irsim_gym.training.run import machine
from irsim_gym.training.trajectory_figures import TrajectoryFigure

WORLDS = 128
"""Default number of worlds that are stepped together."""

Row = TypeVar("Row")


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
        return [summary_table(self.summaries, title), worst, *self.level_set.tables(self.solved)]

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

    def __str__(self) -> str:
        return "\n".join(map(table_text, self.tables))


def evaluate_policies(
    scenario: ScenarioSource,
    sources: Sources,
    *,
    levels: int = 1000,
    split: str = "test",
    task: TaskSource = None,
    n_worlds: int = WORLDS,
    references: bool = True,
    folder: Path | None = None,
    console: Console | None = None,
    parameters: Mapping[str, object] | None = None,
    strict: bool = True,
) -> Evaluation:
    """Evaluate policies and write ``episodes.csv``, ``summary.json``, ``table.txt``, ``ways.png`` and ``ways.pdf``.

    A policy that records the observations and actions of its training keeps them. All others observe and act as the
    task defines. Everything else follows from the task for all policies.

    Args:
        scenario: Shipped name, environment id, path of a scenario file, plain data or a loaded scenario.
        sources: Policies, as ``load_policy`` takes them. In a mapping, each name stands for a method, which is a policy
            or a sequence of seeds.
        levels: Number of levels of the split, from 0.
        split: ``"test"``, ``"dev"`` or ``"train"``.
        task: Shipped name, path or plain data of a task; None for the scenario's own.
        n_worlds: Number of worlds stepped together; the results do not depend on it.
        references: Whether to add the reference policies.
        folder: Folder for the files; None to write none.
        console: Console for the progress bar, which only a terminal shows; None for standard error.
        parameters: Values for the scenario's parameters.
        strict: Whether unused keys are an error; False ignores them.
    """
    made: dict[str, Any] = {"task": task, "parameters": parameters, "strict": strict}
    episodes = make_episodes(scenario, n_worlds=max(1, min(n_worlds, levels)), **made)
    worlds = Perceived(episodes)
    chosen, seeds = named_policies(sources, ALWAYS_SHOWN if references else ())
    figure = None if folder is None else TrajectoryFigure(episodes)
    rows = drive_policies(evaluate, worlds, chosen, levels, split, console or Console(stderr=True), figure)
    played = played_levels(episodes.simulation, split, levels)
    summaries = [summarize(name, rows[name]) for name in rows]
    label, observes = episodes.simulation.scenario.label, observed_by(chosen, worlds)
    found = Evaluation(label, split, rows, summaries, played, seeds, observes)
    if folder is not None and figure is not None:
        write_evaluation(folder, found, conditions(episodes, split, levels))
        rates = {each.policy: f"{rate_text(each.success)} arrive" for each in found.summaries}
        figure.draw(folder, f"{found.scenario}: {levels:,} {split} levels", rates, levels)
    return found


def write_evaluation(folder: Path, found: Evaluation, named: Mapping[str, object]) -> None:
    """Write the rows, the summaries and the tables of an evaluation; ``named`` are its conditions."""
    write_episodes(folder / "episodes.csv", found.rows)
    named = {**named, **found.level_set.conditions()}
    figures = {"conditions": named, "machine": machine(), "policies": found.summaries, "worst": found.worst}
    write_json(folder / "summary.json", {**figures, "observes": found.observes})
    write_text(folder / "table.txt", "\n".join(map(table_text, found.tables)))


def rate_text(share: Rate) -> str:
    """Return a share with its confidence interval, in percent."""
    return f"{percent(share)} % ({100.0 * share.low:.1f}\N{EN DASH}{100.0 * share.high:.1f})"


def named_policies(sources: Sources, references: Sequence[str]) -> tuple[dict[str, Policy], dict[str, list[str]]]:
    """Load policies and give them names.

    Args:
        sources: Policies, see ``evaluate_policies``.
        references: Names of policies to add if they are missing.

    Returns:
        The policies by name, and the names of the policies of each method that has several.
    """
    methods = by_method(sources)
    names = names_of_policies(methods)
    loaded = load_policies([source for several in methods.values() for source in several])
    chosen = dict(zip((name for several in names.values() for name in several), loaded, strict=True))
    chosen |= {name: load_policy(name) for name in references if name not in chosen}
    return chosen, {method: several for method, several in names.items() if len(several) > 1}


def drive_policies(
    evaluation: Callable[..., list[Row]],
    worlds: Perceived,
    policies: Mapping[str, Policy],
    levels: int,
    split: str,
    console: Console,
    figure: TrajectoryFigure | None = None,
) -> dict[str, list[Row]]:
    """Play the same levels with several policies, and return their rows; show a progress bar.

    Args:
        evaluation: ``evaluate`` or ``evaluate_team``.
        worlds: The worlds, as each policy perceives them.
        policies: The policies by name.
        levels: Number of levels of the split, from 0.
        split: ``"test"``, ``"dev"`` or ``"train"``.
        console: Console for the progress bar, which only a terminal shows.
        figure: Collects the trajectories for a figure; None for no figure.

    Raises:
        UnfitPolicyError: If some policies cannot drive the agents.
    """
    check_policies(policies, worlds)
    report_perceptions(policies, worlds)
    optima, rows = Optima(split), {}
    with Progress(console=console, disable=not console.is_terminal, transient=True) as bar:
        for name, policy in policies.items():
            line = bar.add_task(name, total=levels)
            rows[name] = evaluation(
                policy,
                worlds.of(policy),
                levels,
                split,
                optima=optima,
                on_episodes=lambda count, line=line: bar.advance(line, count),
                watcher=None if figure is None else figure.follow(name),
            )
    return rows
