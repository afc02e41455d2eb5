"""The settings of a tuning's trial: its hyper-parameter file and its task file, made from drawn values."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from irsim_gym.errors import IrsimGymError, ScenarioError
from irsim_gym.evaluation.tables import plain, write_text
from irsim_gym.scenario.source import read_file
from irsim_gym.scenario.validation import Report
from irsim_gym.tasks.task import merged_task
from irsim_gym.training.hyperparameter_files import with_value
from irsim_gym.training.models import resolve_device
from irsim_gym.training.policies import load_policy
from irsim_gym.training.run import Settings
from irsim_gym.training.search_space import DIGITS, SearchSpace, Values
from irsim_gym.training.training_request import TrainingRequest

HYPERPARAMETERS, TASK = "hyperparameters.yaml", "task.yaml"
NEEDS = ("device", "clone")
"""Hyper-parameters that name something outside their file, which may be missing."""


def write_settings(
    place: Path, request: TrainingRequest, settings: Settings, hyperparameters: Values, factors: Values
) -> TrainingRequest:
    """Write the files of a trial, and return the arguments of its training.

    Args:
        request: Arguments of the training that is tuned.
        hyperparameters: Drawn hyper-parameters by key.
        factors: Drawn factors on the weights of rewards, by reward.

    Raises:
        IrsimGymError: If the task has no such rewards, or they have no weights.
    """
    chosen = settings.hyperparameters.to_plain()
    if chosen["until"] is not None:
        raise IrsimGymError("'until' ends a single training: it does not go with tune and sweep")
    for key, value in hyperparameters.items():
        chosen = with_value(chosen, key, value)
    write_text(place / HYPERPARAMETERS, yaml.safe_dump({"default": plain(chosen)}, sort_keys=False))
    own: dict[str, Any] = {"hyperparameters": place / HYPERPARAMETERS}
    if factors:
        write_text(place / TASK, yaml.safe_dump(weighted_task(settings, factors), sort_keys=False))
        own["task"] = str(place / TASK)
    return replace(request, steps=None, team=None, curriculum=None, until=None, changes=None, **own)


def weighted_task(settings: Settings, factors: Values) -> Values:
    """Return the complete task, which does not extend another file, with scaled weights of its rewards.

    Raises:
        IrsimGymError: If the task has no such rewards, or they have no weights.
    """
    _, merged = merged_task(settings.load(), settings.task)
    rewards = [dict(one) if isinstance(one, Mapping) else {"name": one} for one in merged.get("rewards", [])]
    named = {one["name"]: one for one in rewards}
    missing = [name for name in factors if not isinstance(named.get(name, {}).get("weight"), int | float)]
    if missing:
        raise IrsimGymError(f"the task gives no weight for {', '.join(missing)}; its rewards are {', '.join(named)}")
    for name, factor in factors.items():
        named[name]["weight"] = float(f"{named[name]['weight'] * factor:.{DIGITS}g}")
    return {**merged, "name": "blank", "rewards": rewards}


def check_space(request: TrainingRequest, settings: Settings, space: SearchSpace) -> None:
    """Check that a training accepts all choices and the limits of all ranges of a search space.

    Raises:
        IrsimGymError: If it does not, or the device or the imitated policy of the training is missing. The message
            lists every problem of the space with its line in the file.
    """
    report = Report(read_file(space.file))
    for name in space.rewards:
        try:
            weighted_task(settings, {name: 1.0})
        except IrsimGymError as error:
            report.add(("rewards", name), str(error))
    for key, one in space.hyperparameters.items():
        for value in one.ends():
            for message in _problems(request, settings, key, value):
                report.add(("hyperparameters", key), message)
    report.check()
    for key in NEEDS:
        if key not in space.hyperparameters:
            _check_need(settings, key)


def _problems(request: TrainingRequest, settings: Settings, key: str, value: object) -> list[str]:
    """Return what is wrong with a training in which one hyper-parameter has another value."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            found = write_settings(Path(folder), request, settings, {key: value}, {}).settings()
        _check_need(found, key)
    except ScenarioError as error:
        return [problem.message for problem in error.problems]
    except IrsimGymError as error:
        return [str(error)]
    return []


def _check_need(settings: Settings, key: str) -> None:
    """Check that what a hyper-parameter names is there. Only ``NEEDS`` name something.

    Raises:
        IrsimGymError: If the device or the policy is missing, or the policy cannot be loaded.
    """
    wanted = settings.hyperparameters
    if key == "device":
        resolve_device(wanted.device)
    elif key == "clone" and wanted.clone is not None:
        load_policy(wanted.clone)
