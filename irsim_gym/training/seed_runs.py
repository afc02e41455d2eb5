"""Several seeds of one training: run one after the other, then summed up."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from rich.console import Console

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.tables import print_table, write_text
from irsim_gym.training.asked import Asked
from irsim_gym.training.commands import run_training
from irsim_gym.training.evaluate import evaluate_policies
from irsim_gym.training.evaluate_teams import evaluate_team_policies
from irsim_gym.training.interruption import ctrl_c_told
from irsim_gym.training.remembered import tell_changes
from irsim_gym.training.run import Run
from irsim_gym.training.seed_summary import (
    Figures,
    markdown_table,
    named_as_runs,
    said_of_seeds,
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
    ``test`` has the evaluation.

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
    """Evaluate finished runs of one training, write the sum beside them and print it."""
    settings, screen = runs[0].settings(), Console(stderr=True)
    is_team, places = settings.hyperparameters.team is not None, [run.folder for run in runs]
    tell_changes(settings.scenario, places[:1], settings.task, strict=settings.strict)
    chosen: dict[str, Any] = {"task": settings.task, "parameters": settings.parameters, "strict": settings.strict}
    evaluated = evaluate_team_policies if is_team else evaluate_policies
    method = settings.algorithm
    found = evaluated(
        settings.scenario, {method: list(places)}, levels=levels, folder=folder / TEST, console=screen, **chosen
    )
    test = named_as_runs(json.loads((folder / TEST / "summary.json").read_text(encoding="utf-8")), places)
    summary = summarize_seeds(test["conditions"]["scenario"], places, [test])
    said = _said(summary, found.worst[method])
    head, rows = seed_cells(summary, next(iter(summary["conditions"])) if is_team else None)
    write_seeds(folder, RESULTS, summary, called=found.scenario)
    write_text(folder / f"{RESULTS}.md", "\n".join([*markdown_table(head, rows), "", said, ""]))
    title = f"{found.scenario}: {method.upper()}, {levels:,} test levels, {found.level_set}"
    print_table(screen_table(title, head, rows))
    print(
        f"{said}\ntable, figures and learning curves: {folder / RESULTS}.md, .json, .png; evaluation: {folder / TEST}"
    )


def _said(summary: Figures, worst: Mapping[str, float]) -> str:
    """Return the middle of the seeds, with an interval, and their success on the worst levels."""
    if "median_test_csr" in summary:
        rows = [next(iter(seed["test"].values()))["cooperative_success"] for seed in summary["seeds"]]
    else:
        rows = [seed["test"]["success"] for seed in summary["seeds"]]
    return said_of_seeds([row["value"] for row in rows], worst)
