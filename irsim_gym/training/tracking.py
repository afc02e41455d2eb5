"""The log of a run: how its episodes end and what its reward terms pay, also for Weights & Biases and MLflow."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence

from irsim_gym.evaluation.tables import write_json
from irsim_gym.sb3 import LogCallback
from irsim_gym.training.run import TRACKING, Run, Settings

PROJECT = "irsim_gym"
CHOSEN_BY = ("WANDB_PROJECT", "MLFLOW_EXPERIMENT_NAME")
"""Variables with which people name the project."""
GROUP = "seed_"


def log_of(run: Run, settings: Settings, services: Sequence[str], *, goes_on: bool) -> LogCallback:
    """Return the callback that logs a run.

    Args:
        run: The run.
        settings: What it trains, which is stored there.
        services: ``"wandb"`` and ``"mlflow"``, or none.
        goes_on: It continues its runs at these services.

    Raises:
        IrsimGymError: There is no such service, or its package is not installed.
    """
    file = run.folder / TRACKING
    run_ids = json.loads(file.read_text(encoding="utf-8")) if goes_on and file.is_file() else {}
    project = None if any(os.environ.get(name) for name in CHOSEN_BY) else PROJECT
    folder = run.folder.resolve()
    name = f"{folder.parent.name}/{folder.name}" if folder.name.startswith(GROUP) else folder.name
    return LogCallback(services, project=project, name=name, config=settings.to_plain(), run_ids=run_ids)


def begin_log(run: Run, log: LogCallback) -> None:
    """Begin the runs at the services, and keep their ids for a training that goes on."""
    log.begin()
    if log.run_ids:
        write_json(run.folder / TRACKING, log.run_ids)
