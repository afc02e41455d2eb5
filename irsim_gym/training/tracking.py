"""The log of a run: outcomes of episodes and reward terms, optionally sent to Weights & Biases and MLflow."""

from __future__ import annotations

import os
from collections.abc import Sequence

from irsim_gym.evaluation.tables import write_json
from irsim_gym.outside_files import json_object, reading
from irsim_gym.sb3 import LogCallback
from irsim_gym.training.run import TRACKING, Run, Settings

PROJECT = "irsim_gym"
"""Default name of the project."""
PROJECT_VARIABLES = ("WANDB_PROJECT", "MLFLOW_EXPERIMENT_NAME")
"""Environment variables that set the name of the project."""
GROUP = "seed_"
"""Prefix of the folders of several seeds."""


def make_log(run: Run, settings: Settings, services: Sequence[str], *, resumed: bool) -> LogCallback:
    """Return the callback that logs a run.

    Args:
        settings: Settings of the run, which are sent to the services.
        services: ``"wandb"`` and ``"mlflow"``, or none.
        resumed: Whether to continue the runs at the services.

    Raises:
        IrsimGymError: If there is no such service, or its package is not installed.
    """
    file = run.folder / TRACKING
    with reading(file, "file with the ids of runs at services"):
        run_ids = json_object(file) if resumed and file.is_file() else {}
    project = None if any(os.environ.get(name) for name in PROJECT_VARIABLES) else PROJECT
    folder = run.folder.resolve()
    name = f"{folder.parent.name}/{folder.name}" if folder.name.startswith(GROUP) else folder.name
    return LogCallback(services, project=project, name=name, config=settings.to_plain(), run_ids=run_ids)


def begin_log(run: Run, log: LogCallback) -> None:
    """Begin the runs at the services, and store their ids for resuming."""
    log.begin()
    if log.run_ids:
        write_json(run.folder / TRACKING, log.run_ids)
