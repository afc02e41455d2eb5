"""Hyper-parameters: a YAML file for each algorithm, with defaults and an entry for each environment id."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from irsim_gym.base.errors import IrsimGymError, suggestion
from irsim_gym.base.options import kind, option, option_fields
from irsim_gym.evaluation.saved_policies.algorithms import find_algorithm
from irsim_gym.scenario.checking.validation import Report, build
from irsim_gym.scenario.text.source import Source
from irsim_gym.training.settings.algorithm_options import ACTIVATIONS, RunKeys
from irsim_gym.training.settings.hyperparameter_files import change_hyperparameters, read_hyperparameters

LEFT_OUT = ("curriculum",)
"""Keys in the settings of earlier runs that no longer are."""
PACKAGE = Path(__file__).parents[2]


@dataclass(frozen=True)
class Linear:
    """A schedule that decreases linearly from ``start`` to 0 at the end of the run, and then stays at 0.

    The last rollout may exceed the end of the run. The remaining share is then negative, so the value is clipped.
    """

    __module__ = "irsim_gym.training"  # as pickles name it, wherever the class is

    start: float

    def __call__(self, remaining: float) -> float:
        """Return the value for the ``remaining`` share of the run."""
        return self.start * max(remaining, 0.0)


@kind
class Hyperparameters(RunKeys):
    """Hyper-parameters of a run: our own keys, see ``RunKeys``, and the arguments of the algorithm, as plain data.

    ``normalize`` holds the arguments of ``VecNormalize``; None for no ``VecNormalize``. ``clone`` is the policy that
    the actor imitates before the training, see ``cloning.clone_behavior``. For ``mirror`` see ``sb3.MirrorCallback``,
    for ``team`` see ``envs.sb3.teams.make_multi_agent_vec_env``.
    """

    arguments: Mapping[str, Any] = option({}, meaning="Arguments of the algorithm.")

    @classmethod
    def from_plain(cls, data: Mapping[str, Any]) -> Self:
        """Make hyper-parameters from a flat mapping, as in the YAML file.

        Raises:
            IrsimGymError: If a required key is missing, or one of our own has an invalid value.
        """
        run_keys = option_fields(RunKeys)
        values = {name: value for name, value in data.items() if name in run_keys}
        report = Report(Source("hyper-parameters", values))
        read = build(cls, values, (), report, skip=("normalize", "arguments"))
        if read is None:
            problems = "; ".join(f"{problem.path} {problem.message}" for problem in report.problems)
            raise IrsimGymError(f"hyper-parameters: {problems}")
        normalize = values.get("normalize")
        normalize = {} if normalize is True else normalize if isinstance(normalize, Mapping) else None
        arguments = {name: value for name, value in data.items() if name not in run_keys and name not in LEFT_OUT}
        return dataclasses.replace(read, normalize=normalize, arguments=arguments)

    def to_plain(self) -> dict[str, Any]:
        """Return the hyper-parameters as the flat mapping that ``from_plain`` reads."""
        data = dataclasses.asdict(self)
        arguments = data.pop("arguments")
        return {**data, **arguments}

    def algorithm_arguments(self) -> dict[str, Any]:
        """Return the arguments of the algorithm, with schedules and activation functions in place of their names.

        ``action_noise`` remains a number, because the noise needs the size of the action.
        """
        arguments = {name: _schedule(value) for name, value in self.arguments.items()}
        if isinstance(arguments.get("train_freq"), list):
            arguments["train_freq"] = tuple(arguments["train_freq"])
        policy = dict(arguments.get("policy_kwargs") or {})
        if isinstance(policy.get("activation_fn"), str):
            policy["activation_fn"] = _activation(policy["activation_fn"])
        return {**arguments, "policy_kwargs": policy}


def _schedule(value: object) -> Any:
    return Linear(float(value.removeprefix("lin_"))) if isinstance(value, str) and value.startswith("lin_") else value


def _activation(name: str) -> Any:
    from torch import nn

    if name not in ACTIVATIONS:
        raise IrsimGymError(f"no activation function named '{name}'{suggestion(name, ACTIVATIONS)}")
    return getattr(nn, ACTIVATIONS[name])


def hyperparameters_folder() -> Path:
    """Return the folder of the shipped files: in the installed package, or in ``agents/`` of a checkout."""
    inside = PACKAGE / "hyperparameters"
    return inside if inside.is_dir() else PACKAGE.parent / "agents" / "hyperparameters"


def load_hyperparameters(
    algorithm: str,
    environment_id: str,
    *,
    images: bool = False,
    overrides: Mapping[str, object] | None = None,
    **layers: Any,
) -> Hyperparameters:
    """Read the hyper-parameters of an algorithm for an environment.

    Args:
        algorithm: Name of the algorithm, e.g. ``"ppo"``.
        environment_id: Id of the environment, e.g. ``"irsim_gym/cluttered_room-v0"``. Without an entry in the file, it
            gets the defaults.
        images: Whether observations contain images. The shipped file is then ``ALGORITHM_images.yaml``, if there is
            one, and ``device`` defaults to ``"auto"``.
        overrides: Values that replace all others.
        **layers: ``task``, ``file`` and ``changes`` of ``stated_hyperparameters``.

    Raises:
        ScenarioError: If the file is invalid. The message lists every problem with its line.
        UnknownNameError: If there is no such algorithm.
        IrsimGymError: If the algorithm is not installed.
    """
    stated = stated_hyperparameters(algorithm, environment_id, images=images, **layers)
    usual = {"device": "auto"} if images else {}
    return Hyperparameters.from_plain({**usual, **stated, **(overrides or {})})


def stated_hyperparameters(
    algorithm: str,
    environment_id: str,
    *,
    task: str | None = None,
    images: bool = False,
    file: Path | None = None,
    changes: Mapping[str, object] | None = None,
) -> dict[str, Any]:
    """Return the plain values of hyper-parameters for an environment; see ``load_hyperparameters``.

    Args:
        environment_id: Id of the environment, whose entry overrides the defaults.
        task: Name of the task, whose entry overrides both; None for the scenario's own.
        images: Whether observations contain images.
        file: Path of a hyper-parameter file that is laid over the shipped one; None for none.
        changes: Single changes to both, as text by key, see ``change_hyperparameters``.
    """
    chosen = find_algorithm(algorithm)
    chosen.load()
    stated: dict[str, Any] = {}
    for layer in (_shipped(algorithm, images), file):
        if layer is not None:
            stated = read_hyperparameters(layer, chosen, environment_id, task, stated)
    return change_hyperparameters(stated, changes, chosen) if changes else stated


def _shipped(algorithm: str, images: bool) -> Path:
    """Return the shipped file of an algorithm; the file for images if requested and available."""
    folder = hyperparameters_folder()
    for_images = folder / f"{algorithm}_images.yaml"
    return for_images if images and for_images.is_file() else folder / f"{algorithm}.yaml"
