"""The function ``irsim_gym.train``: what ``irsim-gym train`` does, from Python."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.extras import require

if TYPE_CHECKING:
    from irsim_gym.training.requests.training_request import TrainingRequest


def train(
    scenario: str | Path,
    out: str | Path | None = None,
    *,
    algorithm: str | None = None,
    steps: int | None = None,
    seed: int = 0,
    task: str | Path | None = None,
    team: str | None = None,
    hyperparameters: str | Path | Mapping[str, object] | None = None,
    until: float | None = None,
    origin: str | Path | None = None,
    dev_levels: int = 1000,
    resume: bool = False,
    more_steps: int | None = None,
    overwrite: bool = False,
    device: str | None = None,
    parameters: Mapping[str, object] | None = None,
    strict: bool = True,
) -> Path:
    """Train a policy, score its checkpoints, and return the folder of the run, as ``irsim-gym train`` does.

    ``load_policy``, ``evaluate`` and all commands take the folder. A second call with the same arguments returns it.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        out: Folder of the run; None for one in ``runs`` that is named after the settings.
        algorithm: Name of the algorithm; None for ``"ppo"``, or that of ``origin``.
        steps: Training steps; None for those of the hyper-parameters.
        seed: Seed of levels, networks and actions.
        task: Shipped name or path of a task; None for the scenario's own.
        team: ``"episode"`` or ``"respawn"``: all robots learn one policy.
        hyperparameters: A YAML file that is laid over the shipped one, or single values by key.
        until: Success on ``dev`` levels [%] at which the training ends.
        origin: Folder or ``policy.zip`` of a run whose weights are the first ones (``--from``).
        dev_levels: Number of levels of ``dev`` on which checkpoints are scored; 0 for none.
        resume: Continue the run in the folder.
        more_steps: Steps that a finished run goes on for, with ``resume``.
        overwrite: Replace the run in the folder.
        device: Device of the networks, such as ``"cuda"``; None for the CPU, or a graphics card for pictures.
        parameters: Values for the scenario's parameters (``--set``).
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.

    Raises:
        IrsimGymError: If an argument is invalid, the folder holds another run, or the networks diverge.
        TrainingInterruptedError: If a signal stops the training; ``resume=True`` continues it.
    """
    require("train", "irsim_gym.train")
    from irsim_gym.cli.work.commands import run_training

    options: dict[str, Any] = {"algorithm": algorithm, "seed": seed, "steps": steps, "team": team, "until": until}
    options |= {"parameters": parameters, "strict": strict, "device": device}
    request = _request(scenario, task, origin, hyperparameters, options)
    how: dict[str, Any] = {"resume": resume, "overwrite": overwrite, "dev_levels": dev_levels}
    return run_training(request, None if out is None else Path(out), more_steps=more_steps, **how).folder


def _request(scenario: Any, task: Any, origin: Any, hyperparameters: Any, options: dict[str, Any]) -> TrainingRequest:
    """Return the request that the command would make."""
    from irsim_gym.training.requests.training_request import TrainingRequest

    if not isinstance(scenario, str | Path):
        raise IrsimGymError("a run reads its scenario from a file, to be resumed: save the scenario and name the file")
    if isinstance(hyperparameters, Mapping):
        options["changes"] = hyperparameters
    elif hyperparameters is not None:
        options["hyperparameters"] = Path(hyperparameters)
    options |= {key: str(name) for key, name in (("task", task), ("origin", origin)) if name is not None}
    return TrainingRequest(str(scenario), **options)
