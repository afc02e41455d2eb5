"""Sweeps: many trainings with Stable-Baselines3, side by side by Ray Tune, on one machine or on a cluster."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.tables import PLAIN, plain, write_json
from irsim_gym.outside_files import json_object, reading, remove
from irsim_gym.training.folders import sole_writer
from irsim_gym.training.interruption import TrainingInterruptedError
from irsim_gym.training.ray_session import ray_session
from irsim_gym.training.run import Run, lasting, scenario_name
from irsim_gym.training.score import Point, score_run
from irsim_gym.training.snapshot import take_snapshot
from irsim_gym.training.sweep_file import Sweep, SweepTrial, read_sweep
from irsim_gym.training.sweep_results import TABLE, read_result, show_sweep, write_result, write_sweep
from irsim_gym.training.train import train
from irsim_gym.training.trial_settings import write_settings

PLAN, TRIALS, TUNE = "sweep.json", "trials", "ray"
FAILURES = 3
"""How often a training that fails, or whose node leaves, is begun again from its newest checkpoint."""


def run_sweep(
    file: Path,
    *,
    out: Path | None = None,
    workers: int = 1,
    address: str | None = None,
    overwrite: bool = False,
    modules: Sequence[str] = (),
) -> Path:
    """Train every combination of a sweep file, and return the folder with the runs and the table.

    A folder with the same sweep is gone on with: finished trainings stay, the others continue at their newest
    checkpoint.

    Args:
        out: The folder; None for ``runs/sweep-NAME``. On a cluster all nodes must see it under this name.
        workers: Trainings at a time on this machine; a cluster takes as many as it has processors.
        address: A Ray cluster; None for this machine.
        overwrite: Replace the sweep in the folder.
        modules: What ``import_modules`` imports first, in each process.

    Raises:
        ScenarioError: The file cannot be used.
        IrsimGymError: The folder holds another sweep, or a training failed.
        TrainingInterruptedError: Ctrl-C; the same command goes on.
    """
    sweep, console = read_sweep(file), Console(stderr=True)
    folder = (out or Path("runs") / f"sweep-{file.stem}").resolve()
    trials = sweep.trials()
    places = [folder / TRIALS / f"{number:04d}" for number in range(len(trials))]
    with sole_writer(folder):
        _begin(folder, sweep, trials, overwrite)
        left = [number for number, place in enumerate(places) if read_result(place) is None]
        console.print(f"sweep of {len(trials)} trainings, {len(left)} of them to do, in {folder}", **PLAIN)
        if left:
            jobs = [_job(sweep, trials[number], places[number], number, modules) for number in left]
            with ray_session(address, workers):
                errors = _fit(jobs, folder)
            _check(folder, places, errors)
    results = [read_result(place) or {} for place in places]
    write_sweep(folder, trials, results)
    show_sweep(trials, results, file.stem)
    print(f"runs: {folder / TRIALS}; table: {folder / TABLE}")
    print(f"learning curves: tensorboard --logdir {folder / TRIALS}")
    return folder


def _begin(folder: Path, sweep: Sweep, trials: Sequence[SweepTrial], overwrite: bool) -> None:
    """Write down what the folder is for.

    Raises:
        IrsimGymError: It is for something else.
    """
    plan = {"sweep": {**asdict(sweep), "file": None}, "scenarios": _digests(sweep, trials)}
    wanted, file = json.loads(json.dumps(plain(plan))), folder / PLAN
    is_replaced = overwrite and file.is_file()
    if is_replaced:
        for name in (TRIALS, TUNE, TABLE, PLAN):
            remove(folder / name)
    if file.is_file():
        with reading(file, "plan of a sweep"):
            found = json_object(file)
        if found != wanted:
            raise IrsimGymError(
                f"{folder} holds another sweep, or its scenario has changed: choose another folder with --out, or "
                "replace it with --overwrite"
            )
        return
    if folder.exists() and any(folder.iterdir()) and not is_replaced:
        raise IrsimGymError(f"{folder} holds something else than a sweep: choose another folder with --out")
    write_json(file, wanted)


def _digests(sweep: Sweep, trials: Sequence[SweepTrial]) -> dict[str, str]:
    """Return what tells whether a scenario or its task has changed."""
    firsts = {trial.scenario: trial for trial in reversed(trials)}
    return {
        name: take_snapshot(lasting(scenario_name(name)), sweep.task, trial.parameters).digest
        for name, trial in firsts.items()
    }


def _job(sweep: Sweep, trial: SweepTrial, place: Path, number: int, modules: Sequence[str]) -> dict[str, Any]:
    """Return all that a process needs for a training, wherever it runs."""
    asked = sweep.asked(trial)
    settings = asked.settings()
    own = write_settings(place, asked, settings, dict(trial.hyperparameters), dict(trial.rewards))
    wanted = own.settings().to_plain()
    return {
        "number": number,
        "settings": wanted,
        "place": str(place),
        "dev_levels": sweep.dev_levels,
        "modules": [str(Path(name).resolve()) if name.endswith(".py") else name for name in modules],
    }


def _fit(jobs: Sequence[dict[str, Any]], folder: Path) -> list[str]:
    """Run the trainings, and return what went wrong in them."""
    from ray import tune

    class Told(tune.Callback):  # type: ignore[misc]
        """Says when a training has ended."""

        def on_trial_complete(self, iteration: int, trials: Any, trial: Any, **info: Any) -> None:
            done = trial.config["job"]
            found = read_result(Path(done["place"])) or {}
            told = f"success {found['success']:.1%}" if "success" in found else "without a result"
            print(f"training {done['number']}: {told}", file=sys.stderr, flush=True)  # Tune pickles this: no console

    remove(folder / TUNE)
    tuner = tune.Tuner(
        tune.with_resources(run_job, {"cpu": 1}),
        param_space={"job": tune.grid_search(list(jobs))},
        tune_config=tune.TuneConfig(metric="success", mode="max"),
        run_config=tune.RunConfig(
            name=TUNE,
            storage_path=str(folder),
            failure_config=tune.FailureConfig(max_failures=FAILURES),
            callbacks=[Told()],
            verbose=0,
        ),
    )
    found = tuner.fit()
    return [str(error) for error in found.errors]


def _check(folder: Path, places: Sequence[Path], errors: Sequence[str]) -> None:
    """Raise unless all trainings have ended.

    Raises:
        IrsimGymError: Some failed.
        TrainingInterruptedError: They were stopped.
    """
    missing = [place.name for place in places if read_result(place) is None]
    if not missing:
        return
    if errors:
        last = errors[0].strip().splitlines()[-1]
        raise IrsimGymError(f"{len(missing)} trainings failed ({', '.join(missing)}) in {folder}: {last}")
    raise TrainingInterruptedError(
        f"stopped with {len(missing)} of {len(places)} trainings to do; run the same command to continue", signal.SIGINT
    )


def run_job(config: dict[str, Any]) -> None:
    """Train, score and write the result of one training; called in a process of its own by Ray Tune."""
    from ray import tune

    from irsim_gym.cli_tools import import_modules
    from irsim_gym.training.run import Settings

    job, quiet = config["job"], Console(quiet=True)
    import_modules(job["modules"])
    settings, run = Settings.from_plain(job["settings"]), Run(Path(job["place"]))

    def report(run: Run) -> Point:
        point = score_run(run, levels=job["dev_levels"], console=quiet, picture=False)[-1]
        tune.report({"success": point["success"], "steps": point["steps"]})
        return point

    train(settings, run.folder, resume=run.exists(), console=quiet, on_checkpoint=report)
    write_result(run.folder, report(run))
