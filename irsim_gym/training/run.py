"""A training run on disk: what was asked for, and where its files lie."""

from __future__ import annotations

import json
import os
import platform
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

from irsim_gym import __version__
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.tables import write_json
from irsim_gym.scenario.ids import IDS
from irsim_gym.scenario.library import SUFFIXES
from irsim_gym.training.hyperparameters import Hyperparameters

SEED_STRIDE = 1_000_000


@dataclass(frozen=True)
class Settings:
    """What a run trains.

    Attributes:
        scenario: Shipped name, or path of a scenario file.
        algorithm: ``"ppo"``, ``"sac"`` or ``"recurrent_ppo"``.
        seed: Seed of the networks, the exploration and the choice of levels.
        task: Shipped name or path of a task; None for the scenario's own.
        hyperparameters: How it is trained.
        parameters: Values of the scenario's parameters by name.
        strict: Keys of the scenario that nobody reads are errors.
    """

    scenario: str
    algorithm: str
    seed: int
    task: str | None
    hyperparameters: Hyperparameters
    parameters: Mapping[str, Any] = field(default_factory=dict)
    strict: bool = True

    @property
    def first_level(self) -> int:
        """First training level: runs with different seeds share no levels."""
        return self.seed * SEED_STRIDE

    def to_plain(self) -> dict[str, Any]:
        """Return them as plain data."""
        return {
            "scenario": self.scenario,
            "algorithm": self.algorithm,
            "seed": self.seed,
            "parameters": dict(self.parameters),
            "task": self.task,
            "hyperparameters": self.hyperparameters.to_plain(),
            **({} if self.strict else {"strict": False}),
        }

    @classmethod
    def from_plain(cls, data: dict[str, Any]) -> Settings:
        """Make them from what ``to_plain`` returned."""
        values = {name: data[name] for name in ("scenario", "algorithm", "seed", "task")}
        wanted = Hyperparameters.from_plain(data["hyperparameters"])
        others = {"parameters": data.get("parameters", {}), "strict": data.get("strict", True)}
        return cls(**values, hyperparameters=wanted, **others)


@dataclass(frozen=True)
class Run:
    """The folder of a run."""

    folder: Path

    @property
    def config(self) -> Path:
        """The settings and the versions they ran with."""
        return self.folder / "config.json"

    @property
    def checkpoints(self) -> Path:
        """A folder per checkpoint, named by its steps."""
        return self.folder / "checkpoints"

    @property
    def policy(self) -> Path:
        """The final policy; it exists only when the run is finished."""
        return self.folder / "policy.zip"

    @property
    def curve(self) -> Path:
        """Scores of the checkpoints."""
        return self.folder / "curve.json"

    def exists(self) -> bool:
        """Return whether a run has begun here."""
        return self.config.is_file()

    def finished(self) -> bool:
        """Return whether the run went through all its steps."""
        return self.policy.is_file()

    def settings(self) -> Settings:
        """Read the settings.

        Raises:
            IrsimGymError: There is no run in the folder.
        """
        try:
            return Settings.from_plain(json.loads(self.config.read_text())["settings"])
        except (OSError, ValueError, KeyError) as error:
            raise IrsimGymError(f"{self.folder} holds no training run: {error}") from error

    def begin(self, settings: Settings) -> None:
        """Write the settings down."""
        write_json(self.config, {"settings": settings.to_plain(), "machine": machine()})


def scenario_name(scenario: str) -> str:
    """Return the shipped name, or the path, of a scenario that may be named by an id.

    Raises:
        IrsimGymError: The id stands for plain data, which no run can be gone on with.
    """
    found = IDS.scenario(scenario)
    if not isinstance(found, str | Path):
        raise IrsimGymError(f"'{scenario}' stands for plain data: write it into a file, and name that")
    return str(found)


def environment_id(scenario: str) -> str:
    """Return the environment id under which hyper-parameters of a scenario are looked up."""
    return f"irsim_gym/{Path(scenario_name(scenario)).stem}-v0"


def lasting(source: str) -> str:
    """Make the path of a file absolute, so that a run can be resumed from another folder."""
    return str(Path(source).resolve()) if Path(source).suffix in SUFFIXES else source


def default_folder(
    scenario: str,
    algorithm: str,
    seed: int,
    parameters: Mapping[str, Any] | None = None,
    team: str | None = None,
) -> Path:
    """Return the folder of a run that was given none."""
    mode = "" if team is None else f"-{team}"
    return Path("runs") / f"{labelled(scenario, parameters)}-{algorithm}{mode}-{seed}"


def evaluation_folder(
    scenario: str, split: str, parameters: Mapping[str, Any] | None = None, team: bool = False
) -> Path:
    """Return the folder of an evaluation that was given none."""
    whose = "-team" if team else ""
    return Path("runs") / f"evaluation-{labelled(scenario, parameters)}{whose}-{split}"


def labelled(scenario: str, parameters: Mapping[str, Any] | None = None) -> str:
    """Return the name of a scenario with its given parameters, as part of a file's name."""
    given = "".join(f"-{name}={value}" for name, value in (parameters or {}).items())
    return re.sub(r"[^\w.=-]", "_", f"{Path(scenario_name(scenario)).stem}{given}")


def machine() -> dict[str, Any]:
    """Return what a figure depends on beside the settings: the machine and the versions."""
    names = ("numpy", "numba", "gymnasium", "stable-baselines3", "torch")
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "versions": {"irsim_gym": __version__, **{name: version(name) for name in names}},
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
