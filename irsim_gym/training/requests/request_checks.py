"""The arguments of a training are checked together, before anything is loaded or written."""

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

from irsim_gym.base.errors import IrsimGymError, report_together
from irsim_gym.evaluation.protocol.protocol import check_levels
from irsim_gym.evaluation.requests.inputs import Check, check_trained, world_checks
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.algorithms import ALGORITHMS, find_algorithm
from irsim_gym.scenario.text.source import read_file
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.settings.hyperparameter_files import check_device
from irsim_gym.training.settings.hyperparameters import Hyperparameters, load_hyperparameters
from irsim_gym.training.settings.run import Settings, environment_id

LEAST = {"n_timesteps": 1, "n_envs": 1}
"""The hyper-parameters without which there are none."""


def check_request(request: TrainingRequest, *further: Check) -> None:
    """Check the arguments of ``irsim-gym train`` that do not depend on each other.

    Args:
        request: The arguments.
        *further: Further checks; each raises an ``IrsimGymError``.

    Raises:
        IrsimGymError: The only problem, or ``SeveralProblemsError`` with all of them.
    """
    report_together(*_worlds(request), *_methods(request), *further)


def check_level_files(settings: Settings, counts: Mapping[str, int]) -> None:
    """Check that the scenarios of a training have as many levels as its policy is scored on, before it is trained.

    Args:
        settings: Settings of the training.
        counts: Number of levels by split; 0 for none.

    Raises:
        IrsimGymError: If a scenario's file of levels has fewer, or no such split.
    """
    for loaded in (part.load() for part in settings.parts()):
        for split, count in counts.items():
            if not count:
                continue
            try:
                check_levels(loaded, split, count)
            except IrsimGymError as error:
                raise IrsimGymError(f"--{split}-levels {count}: {error}") from error


def _worlds(request: TrainingRequest) -> Iterator[Check]:
    for part in request.mixture or (request,):
        how: dict[str, Any] = {"parameters": part.parameters, "strict": request.strict}
        yield from world_checks(ScenarioRequest(part.scenario, request.task, team=request.team is not None, **how))


def _methods(request: TrainingRequest) -> Iterator[Check]:
    if request.algorithm is not None:
        yield partial(find_algorithm, request.algorithm)
    for name, value in request.overrides.items():
        yield partial(Hyperparameters.from_plain, {**LEAST, name: value})
    if request.device is not None:
        yield partial(check_device, request.device)
    if request.hyperparameters is not None or request.changes:
        yield partial(_read_hyperparameters, request)
    if request.origin is not None:
        yield partial(check_trained, request.origin)


def _read_hyperparameters(request: TrainingRequest) -> None:
    """Read the file of hyper-parameters; without a known algorithm, only as YAML."""
    algorithm = request.algorithm or ("ppo" if request.origin is None else None)
    if algorithm not in ALGORITHMS:
        if request.hyperparameters is not None:
            read_file(request.hyperparameters)
        return
    chosen: dict[str, Any] = {"file": request.hyperparameters, "changes": request.changes}
    load_hyperparameters(str(algorithm), environment_id(request.scenario), task=request.task_name, **chosen)
