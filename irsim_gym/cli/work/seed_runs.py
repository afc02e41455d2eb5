"""Training of several seeds, one after the other, with a summary of their results."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from irsim_gym.base.errors import IrsimGymError, report_together
from irsim_gym.base.outside_files import json_object
from irsim_gym.cli.work.commands import run_training
from irsim_gym.evaluation.comparison.evaluate import evaluate_policies
from irsim_gym.evaluation.protocol.tables import figure_table, print_table, write_text
from irsim_gym.evaluation.requests.inputs import check_folder
from irsim_gym.evaluation.requests.interruption import ctrl_c_as_error
from irsim_gym.evaluation.requests.remembered import report_changes
from irsim_gym.evaluation.saved_policies.checkpoint_files import list_checkpoints
from irsim_gym.evaluation.saved_policies.snapshot import listed
from irsim_gym.training.curves import seed_summary
from irsim_gym.training.requests.request_checks import check_level_files, check_request
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.settings.folders import check_replaceable, run_differences
from irsim_gym.training.settings.run import Run, Settings

RESULTS, TEST = "results", "test"
"""Name of the summary's files, and of the folder with the evaluation."""


def run_seeds(
    request: TrainingRequest,
    count: int,
    out: Path | None = None,
    *,
    resume: bool = False,
    overwrite: bool = False,
    dev_levels: int = 1000,
    test_levels: int = 1000,
) -> Path:
    """Train several seeds, evaluate them as one method, print a table, and return the folder that holds the runs.

    ``results.json``, ``results.png`` and ``results.md`` contain the results, the learning curves and the table. The
    folder ``test`` contains the evaluation. A mixture has a folder with these files for each scenario.

    Args:
        request: Arguments of the training, with the first seed.
        count: Number of seeds.
        out: Folder for the runs ``seed_0``, ``seed_1`` and so on; None for the default folder.
        resume: Continue unfinished runs. Finished ones never change.
        overwrite: Replace existing runs.
        dev_levels: Number of ``dev`` levels on which each checkpoint is scored.
        test_levels: Number of ``test`` levels of the evaluation.

    Raises:
        IrsimGymError: If ``dev_levels`` is 0, a folder holds another run, or a file has fewer levels. This is checked
            before any seed is trained.
        TrainingInterruptedError: If Ctrl-C or SIGTERM stops it. Finished parts are on disk.
    """
    if dev_levels < 1:
        raise IrsimGymError("--seeds summarizes scored checkpoints: --dev-levels must be at least 1")
    check_request(request, lambda: check_folder(out))
    folder = out or group_folder(request)
    seeds = range(request.seed, request.seed + count)
    parts = [(replace(request, seed=seed), Run(folder / f"seed_{seed}")) for seed in seeds]
    settings = request.settings()
    check_level_files(settings, {"dev": dev_levels, "test": test_levels})
    report_together(*(partial(_check_place, entry, settings, run, resume, overwrite) for entry, run in parts))
    runs = []
    for part, run in parts:
        how: dict[str, Any] = {"resume": resume and run.exists(), "overwrite": overwrite}
        runs.append(run_training(part, run.folder, dev_levels=dev_levels, **how))
    with ctrl_c_as_error("the trainings are finished, but their evaluation is not: run the same command to continue."):
        summarize_runs(folder, runs, test_levels)
    return folder


def _check_place(request: TrainingRequest, settings: Settings, run: Run, resume: bool, overwrite: bool) -> None:
    """Check that a run can be trained in its folder, before the seeds that come first have taken their time.

    Args:
        request: Arguments of the training, with the seed of this run.
        settings: Settings of the trainings, with any seed.
    """
    check_folder(run.folder)
    seed_settings = replace(settings, seed=request.seed)
    if overwrite:
        check_replaceable(run)
    elif resume and run.exists():
        request.resumed_settings(run, seed_settings)
    elif run.exists():
        _check_repeated(run, seed_settings)


def _check_repeated(run: Run, settings: Settings) -> None:
    """Check that an existing run is finished, or has not begun to learn, and has the requested settings."""
    ways = "choose another folder with --out, or replace the runs with --overwrite"
    differing = run_differences(run, settings, settings.snapshot())
    if differing:
        raise IrsimGymError(f"{run.folder} holds a run with other settings ({listed(differing)}); {ways}")
    if not run.finished() and list_checkpoints(run.checkpoints):
        raise IrsimGymError(f"{run.folder} holds an unfinished run; continue it with --resume, {ways}")


def group_folder(request: TrainingRequest) -> Path:
    """Return the default folder for the runs: that of a single run, with ``seeds`` in place of the seed."""
    single = request.folder(request.settings())
    return single.with_name(f"{single.name.removesuffix(str(request.seed))}seeds")


def summarize_runs(folder: Path, runs: Sequence[Run], levels: int) -> None:
    """Evaluate the finished runs of several seeds, write a summary into their folder, and print it.

    Runs in a mixture are evaluated in each scenario, with a summary in a folder of its name.
    """
    settings = runs[0].settings()
    report_changes(settings.request(), [runs[0].folder])
    if not settings.mixture:
        _summarize(folder, settings, runs, levels)
        return
    for name, part in zip(settings.names, settings.parts(), strict=True):
        _summarize(folder / name, part, runs, levels, name)


def _summarize(folder: Path, settings: Settings, runs: Sequence[Run], levels: int, part: str | None = None) -> None:
    """Evaluate runs in one scenario, write the summary and print it.

    Args:
        folder: Folder of the summary.
        settings: Settings of the runs in this scenario.
        levels: Number of levels of ``test``.
        part: Name of the scenario in a mixture; None if there is only one scenario.
    """
    is_team, places = settings.is_team, [run.folder for run in runs]
    method = settings.algorithm
    evaluation = evaluate_policies(settings.request(), {method: list(places)}, levels=levels, folder=folder / TEST)
    test = seed_summary.named_as_runs(json_object(folder / TEST / "summary.json"), places)
    summary = seed_summary.summarize_seeds(test["conditions"]["scenario"], places, [test], part)
    line = _summary_line(summary, evaluation.worst[method])
    head, rows = seed_summary.seed_cells(summary, next(iter(summary["conditions"])) if is_team else None)
    seed_summary.write_seeds(folder, RESULTS, summary, called=evaluation.scenario)
    write_text(folder / f"{RESULTS}.md", "\n".join([*seed_summary.markdown_table(head, rows), "", line, ""]))
    title = f"{evaluation.scenario}: {method.upper()}, {levels:,} test levels, {evaluation.level_set}"
    print_table(figure_table(title, head, rows))
    print(f"{line}\ntable, summary and curves: {folder / RESULTS}.md, .json, .png; evaluation: {folder / TEST}")


def _summary_line(summary: seed_summary.Figures, worst: Mapping[str, float]) -> str:
    """Return the median and the interquartile mean of the seeds, and their success on the worst levels."""
    if "median_test_csr" in summary:
        rows = [next(iter(seed["test"].values()))["cooperative_success"] for seed in summary["seeds"]]
    else:
        rows = [seed["test"]["success"] for seed in summary["seeds"]]
    return seed_summary.said_of_seeds([row["value"] for row in rows], worst)
