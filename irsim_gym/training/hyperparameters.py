"""Hyper-parameters: one YAML file per algorithm, an entry per environment id over a default."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from irsim_gym.errors import IrsimGymError, suggestion
from irsim_gym.training.algorithm_options import ACTIVATIONS
from irsim_gym.training.algorithms import find_algorithm
from irsim_gym.training.hyperparameter_files import read_hyperparameters

TEAM_MODES = ("episode", "respawn")
CURRICULA = ("learnability",)
PACKAGE = Path(__file__).parent.parent


@dataclass(frozen=True)
class Linear:
    """A schedule that falls from ``start`` to 0 in proportion to what remains of the run, and stays there.

    The last rollout may go beyond the end of the run; what remains is then negative, and so would be the value.
    """

    start: float

    def __call__(self, remaining: float) -> float:
        """Return the value when the share ``remaining`` of the run is left."""
        return self.start * max(remaining, 0.0)


@dataclass(frozen=True)
class Hyperparameters:
    """How one agent is trained.

    Attributes:
        n_timesteps: Steps of the whole run, counted over all worlds and robots, those that wait included.
        n_envs: Worlds in the batch.
        team: What robots that have ended do while others learn on, ``"episode"`` or ``"respawn"``; see
            ``envs.sb3.make_multi_agent_vec_env``. None where one robot learns.
        curriculum: Which levels are played again, ``"learnability"``: see ``sb3.LearnabilityCallback``; None for none.
        clone: What the actor imitates first, see ``cloning.clone_behavior``; None for nothing.
        clone_levels: Levels that the imitated policy plays.
        clone_epochs: Passes over what it did there.
        torch_threads: Threads of PyTorch.
        checkpoint_every: Steps between checkpoints.
        reward_scale: Factor on the rewards that the algorithm sees.
        normalize: Arguments of ``VecNormalize``; None to go without.
        device: Where the networks are: ``"cpu"``, ``"auto"``, ``"cuda"``, ``"cuda:1"`` or ``"mps"``.
        arguments: The algorithm's own arguments, as plain data.
    """

    n_timesteps: int
    n_envs: int
    team: str | None = None
    curriculum: str | None = None
    clone: str | None = None
    clone_levels: int = 2000
    clone_epochs: int = 8
    torch_threads: int = 1
    checkpoint_every: int = 100_000
    reward_scale: float = 1.0
    normalize: Mapping[str, Any] | None = None
    device: str = "cpu"
    arguments: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def from_plain(cls, data: Mapping[str, Any]) -> Hyperparameters:
        """Make them from a flat mapping, as it stands in the YAML file."""
        own = {f.name for f in dataclasses.fields(cls)} - {"arguments"}
        missing = {"n_timesteps", "n_envs"} - data.keys()
        if missing:
            raise IrsimGymError(f"hyper-parameters lack {', '.join(sorted(missing))}")
        values = {name: data[name] for name in own & data.keys()}
        for name, known in (("team", TEAM_MODES), ("curriculum", CURRICULA)):
            if values.get(name) not in (None, *known):
                near = suggestion(str(values[name]), known)
                raise IrsimGymError(f"{name} must be {' or '.join(known)}, got {values[name]!r}{near}")
        normalize = values.get("normalize")
        if normalize is True:
            values["normalize"] = {}
        elif not normalize and not isinstance(normalize, Mapping):
            values["normalize"] = None
        return cls(**values, arguments={name: value for name, value in data.items() if name not in own})

    def to_plain(self) -> dict[str, Any]:
        """Return them as the flat mapping that ``from_plain`` reads."""
        data = dataclasses.asdict(self)
        arguments = data.pop("arguments")
        return {**data, **arguments}

    def algorithm_arguments(self) -> dict[str, Any]:
        """Return the arguments with schedules and activation functions made from their names.

        ``action_noise`` stays a number, because the noise of Stable-Baselines3 has as many components as the action.
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
    """Return the folder of the shipped files: inside an installed package, else ``agents/`` of a checkout."""
    inside = PACKAGE / "hyperparameters"
    return inside if inside.is_dir() else PACKAGE.parent / "agents" / "hyperparameters"


def load_hyperparameters(
    algorithm: str,
    environment_id: str,
    *,
    task: str | None = None,
    images: bool = False,
    file: Path | None = None,
    overrides: Mapping[str, object] | None = None,
) -> Hyperparameters:
    """Read the hyper-parameters of an algorithm for an environment.

    Args:
        algorithm: One of ``algorithms.ALGORITHMS``, e.g. ``"ppo"``.
        environment_id: E.g. ``"irsim_gym/cluttered_room-v0"``; one that is not in the file gets the default.
        task: Name of a task in place of the scenario's own, which may have an entry of its own.
        images: Observations hold pictures; where the algorithm has a file for these, ``ALGORITHM_images.yaml``, it is
            read in place of the other. The networks are then on a graphics card where there is one, unless ``device``
            says otherwise.
        file: A file to use in place of the shipped one.
        overrides: Values that replace those of the file.

    Raises:
        ScenarioError: The file cannot be used; the error lists every problem with its line.
        UnknownNameError: No such algorithm.
        IrsimGymError: The algorithm is not installed.
    """
    given = dict(overrides or {})
    stated = stated_hyperparameters(algorithm, environment_id, task=task, images=images, file=file, given=given)
    usual = {"device": "auto"} if images else {}
    return Hyperparameters.from_plain({**usual, **stated, **given})


def stated_hyperparameters(
    algorithm: str,
    environment_id: str,
    *,
    task: str | None = None,
    images: bool = False,
    file: Path | None = None,
    given: Iterable[str] = (),
) -> dict[str, Any]:
    """Return what stands in a hyper-parameter file for an environment; see ``load_hyperparameters``.

    Args:
        algorithm: The algorithm.
        environment_id: The entry that is laid over the default.
        task: The task whose entry for this environment is laid over that.
        images: Observations hold pictures.
        file: A file to use in place of the shipped one.
        given: Keys that are given elsewhere, so that the file need not have them.
    """
    chosen = find_algorithm(algorithm)
    chosen.load()
    return read_hyperparameters(file or _shipped(algorithm, images), chosen, environment_id, task, given)


def _shipped(algorithm: str, images: bool) -> Path:
    """Return the shipped file of an algorithm; the one for images if requested and available."""
    folder = hyperparameters_folder()
    for_images = folder / f"{algorithm}_images.yaml"
    return for_images if images and for_images.is_file() else folder / f"{algorithm}.yaml"
