"""Several seeds of one training: run one after the other, then summed up."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

from rich.console import Console

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.statistics import interquartile_mean
from irsim_gym.evaluation.tables import print_table, write_text
from irsim_gym.training.asked import Asked
from irsim_gym.training.commands import run_training
from irsim_gym.training.evaluate import Evaluation, evaluate_policies
from irsim_gym.training.evaluate_teams import TeamEvaluation, evaluate_team_policies
from irsim_gym.training.interruption import ctrl_c_told
from irsim_gym.training.remembered import tell_changes
from irsim_gym.training.run import Run, Settings
from irsim_gym.training.seed_summary import (
    Figures,
    markdown_table,
    screen_table,
    seed_cells,
    summarize_seeds,
    write_seeds,
)

RESULTS, TEST = "results", "test"
"""Names of the sum's files, and of the folder with the evaluation."""


def run_seeds(
    asked: Asked,
    count: int,
    out: Path | None = None,
    *,
    resume: bool = False,
    overwrite: bool = False,
    dev_levels: int = 1000,
    test_levels: int = 1000,
    address: str | None = None,
) -> Path:
    """Train several seeds, evaluate them as one method, print one table and return the folder above the runs.

    ``results.json``, ``results.png`` and ``results.md`` have the figures, the learning curves and the table; the folder
    ``test`` has the evaluation. Of a mixture, each scenario has a folder with these.

    Args:
        asked: What is trained; its seed is the first one.
        count: How many seeds.
        out: The folder above the runs ``seed_0``, ``seed_1`` and so on; None for one named after what is trained.
        resume: Go on with unfinished runs; finished ones stay as they are in any case.
        overwrite: Replace the runs.
        dev_levels: Levels of ``dev`` for each checkpoint.
        test_levels: Levels of ``test`` for the sum.
        address: A Ray cluster, for runs with RLlib.

    Raises:
        IrsimGymError: Checkpoints are not to be scored, or a folder holds another run.
        TrainingInterruptedError: Ctrl-C or SIGTERM; what is finished is on disk.
    """
    if dev_levels < 1:
        raise IrsimGymError("--seeds sums up scored checkpoints: --dev-levels must be at least 1")
    folder = out or group_folder(asked)
    runs = []
    for seed in range(asked.seed, asked.seed + count):
        own, place = replace(asked, seed=seed), folder / f"seed_{seed}"
        goes_on = resume and Run(place).exists()
        how: dict[str, Any] = {"resume": goes_on, "overwrite": overwrite, "dev_levels": dev_levels, "address": address}
        runs.append(run_training(own, place, **how))
    with ctrl_c_told("the trainings are finished, but their evaluation is not: run the same command to continue."):
        sum_up(folder, runs, test_levels)
    return folder


def group_folder(asked: Asked) -> Path:
    """Return the default folder above the runs: that of a single run, with ``seeds`` in the place of the seed."""
    single = asked.folder(asked.settings())
    return single.with_name(f"{single.name.removesuffix(str(asked.seed))}seeds")


def sum_up(folder: Path, runs: Sequence[Run], levels: int) -> None:
    """Evaluate finished runs of one training, write the sum beside them and print it.

    Runs in a mixture are evaluated in each scenario, with a sum in a folder of its name.
    """
    settings = runs[0].settings()
    tell_changes(settings.scenario, [runs[0].folder], settings.task, strict=settings.strict)
    if not settings.mixture:
        _sum_up(folder, settings, runs, levels)
    for name, part in zip(settings.names, settings.parts(), strict=True) if settings.mixture else ():
        _sum_up(folder / name, part, runs, levels, name)


def _sum_up(folder: Path, settings: Settings, runs: Sequence[Run], levels: int, part: str | None = None) -> None:
    """Evaluate runs in one scenario, write the sum and print it.

    Args:
        folder: Where the sum goes.
        settings: What the runs trained, in this scenario.
        runs: The runs.
        levels: Levels of ``test``.
        part: Name of the scenario in a mixture; None where it is the only one.
    """
    is_team, places = settings.hyperparameters.team is not None, [run.folder for run in runs]
    chosen: dict[str, Any] = {"task": settings.task, "parameters": settings.parameters, "strict": settings.strict}
    evaluated = evaluate_team_policies if is_team else evaluate_policies
    method = settings.algorithm
    found = evaluated(
        settings.scenario,
        {method: list(places)},
        levels=levels,
        folder=folder / TEST,
        console=Console(stderr=True),
        **chosen,
    )
    test = _by_run(folder / TEST / "summary.json", runs)
    summary = summarize_seeds(test["conditions"]["scenario"], places, [test], part)
    said = _said(summary, found, method)
    head, rows = seed_cells(summary, next(iter(summary["conditions"])) if is_team else None)
    write_seeds(folder, RESULTS, summary, called=found.scenario)
    write_text(folder / f"{RESULTS}.md", "\n".join([*markdown_table(head, rows), "", said, ""]))
    title = f"{found.scenario}: {method.upper()}, {levels:,} test levels, {found.level_set}"
    print_table(screen_table(title, head, rows))
    print(
        f"{said}\ntable, figures and learning curves: {folder / RESULTS}.md, .json, .png; evaluation: {folder / TEST}"
    )


def _by_run(file: Path, runs: Sequence[Run]) -> Figures:
    """Return an evaluation of one method whose policies, the first rows, are named as the runs' folders."""
    test: Figures = json.loads(file.read_text(encoding="utf-8"))
    rows = test["policies"]
    named = [{**row, "policy": run.folder.name} for row, run in zip(rows[: len(runs)], runs, strict=True)]
    return {**test, "policies": [*named, *rows[len(runs) :]]}


def _said(summary: Figures, found: Evaluation | TeamEvaluation, method: str) -> str:
    """Return the middle of the seeds, with an interval, and their success on the worst levels."""
    is_team = "median_test_csr" in summary
    key = "cooperative_success" if is_team else "success"
    rows = [next(iter(seed["test"].values())) if is_team else seed["test"] for seed in summary["seeds"]]
    shares = [100.0 * row[key]["value"] for row in rows]
    mean = interquartile_mean([shares])
    interval = f" [{mean.low:.1f}, {mean.high:.1f}]" if len(shares) > 1 else ""
    worst = ", ".join(f"{100.0 * value:.1f} % on the worst {name}" for name, value in found.worst[method].items())
    return f"median {median(shares):.1f} %, interquartile mean {mean.value:.1f} %{interval} over seeds; {worst}"
