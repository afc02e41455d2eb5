"""Weights & Biases and MLflow as outputs of Stable-Baselines3's logger."""

from __future__ import annotations

import importlib
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

from stable_baselines3.common.logger import KVWriter

from irsim_gym.errors import IrsimGymError, suggestion
from irsim_gym.extras import pip_command

LONGEST_PARAMETER = 500
"""Characters of a parameter that every server of MLflow takes."""


class Tracker(KVWriter, ABC):
    """A run at a tracking service, which gets each number that the logger gets.

    Attributes:
        run_id: The run's id there, with which it can be continued.
    """

    run_id: str

    def write(self, key_values: dict[str, Any], key_excluded: dict[str, tuple[str, ...]], step: int = 0) -> None:
        """Send the numbers of a step; what the logger keeps from TensorBoard is left out here too."""
        found = {key: float(value) for key, value in key_values.items() if _is_number(value)}
        kept = {key: value for key, value in found.items() if "tensorboard" not in (key_excluded.get(key) or ())}
        if kept:
            self.send(kept, step)

    @abstractmethod
    def send(self, numbers: Mapping[str, float], step: int) -> None:
        """Send numbers by name."""


class WandbTracker(Tracker):
    """A run of Weights & Biases; one that is under way is used, and stays open.

    Args:
        project: Name of the project; None for W&B's own choice.
        name: Name of the run; None for W&B's own choice.
        config: Settings to store with the run.
        run_id: Id of a run to continue.
        settings: More arguments of ``wandb.init``.
    """

    def __init__(
        self,
        project: str | None,
        name: str | None,
        config: Mapping[str, Any],
        run_id: str | None,
        settings: Mapping[str, Any],
    ) -> None:
        wandb = _module("wandb")
        self._opened = None
        self._run = wandb.run
        if self._run is None:
            continued = {} if run_id is None else {"id": run_id, "resume": "allow"}
            given = {"project": project, "name": name, "config": dict(config), **continued, **settings}
            self._opened = self._run = wandb.init(**given)
        self.run_id = self._run.id
        # A run that goes on from a checkpoint repeats some steps, which W&B's own counter does not allow.
        self._run.define_metric("steps")
        self._run.define_metric("*", step_metric="steps")

    def send(self, numbers: Mapping[str, float], step: int) -> None:
        """Send numbers by name."""
        self._run.log({**numbers, "steps": step})

    def close(self) -> None:
        """Finish the run if it was begun here. May be called twice."""
        opened, self._opened = self._opened, None
        if opened is not None:
            opened.finish()


class MlflowTracker(Tracker):
    """A run of MLflow; one that is under way is used, and stays open.

    Args:
        project: Name of the experiment; None for MLflow's own choice.
        name: Name of the run; None for MLflow's own choice.
        config: Settings to store with the run, as parameters.
        run_id: Id of a run to continue.
        settings: More arguments of ``mlflow.start_run``.
    """

    def __init__(
        self,
        project: str | None,
        name: str | None,
        config: Mapping[str, Any],
        run_id: str | None,
        settings: Mapping[str, Any],
    ) -> None:
        self._mlflow = _module("mlflow")
        active = self._mlflow.active_run()
        self._is_ours = active is None
        if active is None:
            if project is not None:
                self._mlflow.set_experiment(project)
            active = self._mlflow.start_run(run_id=run_id, run_name=name, **settings)
        self.run_id = active.info.run_id
        if self._is_ours and run_id is None and config:
            self._mlflow.log_params({key: str(value)[:LONGEST_PARAMETER] for key, value in _flat(config).items()})

    def send(self, numbers: Mapping[str, float], step: int) -> None:
        """Send numbers by name."""
        self._mlflow.log_metrics(dict(numbers), step=step, run_id=self.run_id)

    def close(self) -> None:
        """Finish the run if it was begun here. May be called twice."""
        if self._is_ours:
            self._is_ours = False
            self._mlflow.end_run()


TRACKERS: Mapping[str, type[WandbTracker | MlflowTracker]] = {"wandb": WandbTracker, "mlflow": MlflowTracker}


def find_tracker(name: str) -> type[WandbTracker | MlflowTracker]:
    """Return the tracker of a name.

    Raises:
        IrsimGymError: There is none, or its package is not installed.
    """
    if name not in TRACKERS:
        raise IrsimGymError(f"no log named '{name}'{suggestion(name, TRACKERS)}; there are {' and '.join(TRACKERS)}")
    _module(name)
    return TRACKERS[name]


def _module(name: str) -> Any:
    """Return the package of a service, whose extra has the same name."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise IrsimGymError(f"the package {name} is not installed: {pip_command(name)}") from None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) or (hasattr(value, "item") and getattr(value, "size", 1) == 1)


def _flat(config: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """Return nested settings as one mapping: ``hyperparameters.gamma`` and so on."""
    found: dict[str, Any] = {}
    for key, value in config.items():
        name = f"{above}{key}"
        found.update(_flat(value, f"{name}.") if isinstance(value, Mapping) and value else {name: value})
    return found
