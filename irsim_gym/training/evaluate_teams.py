"""Evaluation of policies that drive whole teams on the levels of a split, with the reference policies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from irsim_gym.envs.worlds import ScenarioSource, TaskSource
from irsim_gym.evaluation.behavior_policies import BehaviorPolicy, UnfitBehaviorError
from irsim_gym.evaluation.perception import Perceived
from irsim_gym.evaluation.policy import Policy
from irsim_gym.evaluation.reference_policies import TEAM_SHOWN
from irsim_gym.evaluation.tables import percent, table_text, worst_table, write_json, write_text
from irsim_gym.evaluation.team_metrics import TeamRow, TeamSummary, summarize_teams
from irsim_gym.evaluation.team_tables import compared_table, team_table, write_agents, write_levels
from irsim_gym.evaluation.teams import evaluate_team
from irsim_gym.evaluation.worst_levels import worst_of_policies
from irsim_gym.levels.played import PlayedLevels, played_levels
from irsim_gym.tasks import Episodes
from irsim_gym.training.episode_setup import make_episodes, team_conditions
from irsim_gym.training.evaluate import WORLDS, drive_policies, named_policies, rate_text
from irsim_gym.training.fitting import observed_by
from irsim_gym.training.methods import Sources
from irsim_gym.training.run import machine
from irsim_gym.training.trajectory_figures import TrajectoryFigure


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
        compared = compared_table(self.summaries)
        tables = [team_table(self.summaries, title), *([] if compared is None else [compared])]
        return [*tables, worst_table(self.worst, self.seeds), *self.level_set.tables(self.solved)]

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

    def __str__(self) -> str:
        return "\n".join(map(table_text, self.tables))


def evaluate_team_policies(
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
) -> TeamEvaluation:
    """Evaluate policies of teams; write ``episodes.csv``, ``levels.csv``, ``summary.json``, ``table.txt``, ``ways.*``.

    Reference policies that cannot drive all robots are left out, with a message. Policies observe what they observe
    in ``evaluate_policies``.

    Args:
        scenario: Shipped name, environment id, path of a scenario file, plain data or a loaded scenario.
        sources: Policies, as ``load_policy`` takes them. In a mapping, each name stands for a method, which is a policy
            or a sequence of seeds. All robots of a team share a policy.
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
    n_worlds = max(1, min(n_worlds, levels))
    made: dict[str, Any] = {"task": task, "parameters": parameters, "strict": strict}
    episodes = make_episodes(scenario, n_worlds=n_worlds, team=True, **made)
    worlds = Perceived(episodes)
    screen = console or Console(stderr=True)
    chosen, seeds = named_policies(sources, ())
    if references:
        shown, _ = named_policies((), [name for name in TEAM_SHOWN if name not in chosen])
        chosen = {**chosen, **_fitting(shown, episodes, screen)}
    figure = None if folder is None else TrajectoryFigure(episodes)
    rows = drive_policies(evaluate_team, worlds, chosen, levels, split, screen, figure)
    played = played_levels(episodes.simulation, split, levels)
    label, observes = episodes.simulation.scenario.label, observed_by(chosen, worlds)
    found = TeamEvaluation(label, split, rows, summarize_teams(rows), played, seeds, observes)
    if folder is not None and figure is not None:
        write_team_evaluation(folder, found, team_conditions(episodes, split, levels))
        rates = {
            each.policy: f"all arrive in {rate_text(each.cooperative_success)} of the levels, "
            f"{percent(each.individual_success)} % of the robots"
            for each in found.summaries
        }
        figure.draw(folder, f"{found.scenario}: {episodes.n_agents} robots, {levels:,} {split} levels", rates, levels)
    return found


def write_team_evaluation(folder: Path, found: TeamEvaluation, named: Mapping[str, object]) -> None:
    """Write the rows of agents and levels, the summaries and the tables; ``named`` are the conditions."""
    write_agents(folder / "episodes.csv", found.rows)
    write_levels(folder / "levels.csv", found.rows)
    named = {**named, **found.level_set.conditions()}
    figures = {"conditions": named, "machine": machine(), "policies": found.summaries, "worst": found.worst}
    write_json(folder / "summary.json", {**figures, "observes": found.observes})
    write_text(folder / "table.txt", "\n".join(map(table_text, found.tables)))


def _fitting(policies: Mapping[str, Policy], episodes: Episodes, screen: Console) -> dict[str, Policy]:
    """Return the policies that can drive all robots, and print why the others cannot."""
    fitting = {}
    for name, policy in policies.items():
        try:
            if isinstance(policy, BehaviorPolicy):
                policy.check(episodes)
            fitting[name] = policy
        except UnfitBehaviorError as problem:
            screen.print(f"without {name}: {problem}", markup=False, highlight=False)
    return fitting
