"""The settings of a tuning's trial, made from drawn values."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from irsim_gym.base.errors import IrsimGymError, ScenarioError
from irsim_gym.evaluation.protocol.tables import write_text
from irsim_gym.evaluation.saved_policies.policies import load_policy
from irsim_gym.scenario.checking.validation import Report
from irsim_gym.scenario.text.source import read_file
from irsim_gym.tasks.definition.task import merged_task
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.runs.models import resolve_device
from irsim_gym.training.searches.search_space import DIGITS, Axis, SearchSpace
from irsim_gym.training.settings.run import Settings

TASK = "task.yaml"


def trial_settings(request: TrainingRequest, drawn: Mapping[Axis, Any], place: Path) -> Settings:
    """Return the settings of a trial, and write its task to its folder if the weights of rewards are drawn.

    Args:
        request: Arguments of the training that is tuned.
        drawn: Drawn values by axis.
        place: Folder of the trial.

    Raises:
        IrsimGymError: If the scenario, the task or the algorithm does not take the values.
    """
    parts: dict[str, dict[str, Any]] = {"hyperparameters": {}, "rewards": {}, "parameters": {}}
    for part, key in (axis for axis in drawn if len(axis) > 1):
        parts[part][key] = drawn[part, key]
    values: dict[str, Any] = {
        "scenario": drawn.get(("scenario",), request.scenario),
        "seed": drawn.get(("seeds",), request.seed),
        "parameters": {**(request.parameters or {}), **parts["parameters"]} or None,
        "changes": {**(request.changes or {}), **parts["hyperparameters"]} or None,
    }
    settings = replace(request, **values).settings()
    if settings.hyperparameters.until is not None:
        raise IrsimGymError("'until' ends a single training: it does not go with tune")
    if parts["rewards"]:
        write_text(place / TASK, yaml.safe_dump(weighted_task(settings, parts["rewards"]), sort_keys=False))
        settings = replace(settings, task=str((place / TASK).resolve()))
        settings.load_task()
    return settings


def weighted_task(settings: Settings, factors: Mapping[str, float]) -> dict[str, Any]:
    """Return the complete task, which does not extend another file, with scaled weights of its rewards.

    Raises:
        IrsimGymError: If the task has no such rewards, or they have no weights.
    """
    _, merged = merged_task(settings.load(), settings.task)
    rewards = [dict(term) if isinstance(term, Mapping) else {"name": term} for term in merged.get("rewards", [])]
    named = {term["name"]: term for term in rewards}
    missing = [name for name in factors if not isinstance(named.get(name, {}).get("weight"), int | float)]
    if missing:
        raise IrsimGymError(f"the task gives no weight for {', '.join(missing)}; its rewards are {', '.join(named)}")
    for name, factor in factors.items():
        named[name]["weight"] = float(f"{named[name]['weight'] * factor:.{DIGITS}g}")
    return {**merged, "name": "blank", "rewards": rewards}


def check_space(request: TrainingRequest, space: SearchSpace, scenarios: Sequence[str] = ()) -> None:
    """Check that a training accepts each value of the lists and the limits of the ranges of a search space.

    Args:
        scenarios: Scenarios of the trials; none for that of the request.

    Raises:
        IrsimGymError: If it does not, or the device or the imitated policy of the training is missing. The message
            lists every problem of the space with its line in the file.
    """
    report = Report(read_file(space.file))
    for single in (replace(request, scenario=scenario) for scenario in scenarios or (request.scenario,)):
        settings = single.settings()
        _check_places(settings)
        values = [(axis, value) for axis, domain in space.axes.items() if len(axis) > 1 for value in domain.ends()]
        for axis, value in values:
            try:
                if axis[0] == "rewards":
                    weighted_task(settings, {axis[1]: 1.0})
                else:
                    _check_places(trial_settings(single, {axis: value}, Path()))
            except IrsimGymError as error:
                problems = error.problems if isinstance(error, ScenarioError) else ()
                for message in [problem.message for problem in problems] or [str(error)]:
                    report.add(axis, message)
    report.check()


def _check_places(settings: Settings) -> None:
    """Check that the device and the imitated policy are there.

    Raises:
        IrsimGymError: If one is missing, or the policy cannot be loaded.
    """
    resolve_device(settings.hyperparameters.device)
    if settings.hyperparameters.clone is not None:
        load_policy(settings.hyperparameters.clone)
