"""Training runs on disk: their settings and their files."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

from irsim_gym.base.errors import UnreadableFileError
from irsim_gym.base.outside_files import checked, json_object, reading, remove
from irsim_gym.evaluation.policies.perception import Perception, perception_of
from irsim_gym.evaluation.protocol.tables import write_json
from irsim_gym.evaluation.requests.machine import machine
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.run_folder import CONFIG_KIND, RunFolder, folder_of
from irsim_gym.evaluation.saved_policies.snapshot import Snapshot, differences, read_snapshot, snapshot_of
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.reading.parameters import BESIDE
from irsim_gym.scenario.specs.ids import scenario_name
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.tasks import Task, load_task
from irsim_gym.training.settings.hyperparameters import Hyperparameters
from irsim_gym.training.settings.mixture import MixturePart

SEED_STRIDE = 1_000_000
"""Distance between the first levels of consecutive seeds."""
FILES = ("policy.zip", "vecnormalize.pkl", "training.csv", "curve.json", "curve.csv", "curve.png", "config.json")
"""Files that a run writes, each first to a temporary file. The settings come last, because they are removed last."""
FOLDERS = ("checkpoints", "tensorboard", "scenario")
"""Folders that a run writes."""


@dataclass(frozen=True)
class Settings:
    """Settings of a training run.

    Attributes:
        scenario: Shipped name, or path of a scenario file.
        algorithm: Name of the algorithm, e.g. ``"ppo"``.
        seed: Seed of the networks, the exploration and the choice of levels.
        task: Shipped name or path of a task; None for the scenario's own.
        hyperparameters: Hyper-parameters.
        parameters: Values of the scenario's parameters.
        strict: Whether unused keys of the scenario are an error.
        origin: Policy that the run starts from: the path of its file, ``policy``, and its hash, ``sha256``; None for
            random weights.
        mixture: All scenarios of the training, including ``scenario``; empty for a single scenario.
    """

    scenario: str
    algorithm: str
    seed: int
    task: str | None
    hyperparameters: Hyperparameters
    parameters: Mapping[str, object] = field(default_factory=dict)
    strict: bool = True
    origin: Mapping[str, str] | None = None
    mixture: tuple[MixturePart, ...] = ()

    def parts(self) -> tuple[Self, ...]:
        """Return the settings for each scenario of a mixture; for a single scenario, these settings."""
        alone = replace(self, mixture=())
        return tuple(replace(alone, scenario=part.scenario, parameters=part.parameters) for part in self.mixture) or (
            self,
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Unique names of the scenarios in tables. Repeated scenarios are named with the values of their parameters."""
        stems = [Path(part.scenario).stem for part in self.parts()]
        values = [_values(part.parameters) for part in self.parts()]
        named = [f"{stem}{text}" if stems.count(stem) > 1 else stem for stem, text in zip(stems, values, strict=True)]
        return tuple(f"{name}-{k}" if name in named[: k - 1] else name for k, name in enumerate(named, start=1))

    def snapshot(self) -> Snapshot:
        """Return a snapshot of the current scenario and task."""
        return snapshot_of(self.load(), self.task)

    @property
    def is_team(self) -> bool:
        """Whether robots learn as a team."""
        return self.hyperparameters.team is not None

    def load(self) -> Scenario:
        """Load the scenario."""
        return load_scenario(self.scenario, self.parameters, strict=self.strict, warn=False)

    def load_task(self) -> tuple[Scenario, Task]:
        """Load the scenario and its task."""
        scenario = self.load()
        return scenario, load_task(scenario, self.task, team=self.is_team)

    def perception(self) -> Perception:
        """Return what a policy perceives in the training."""
        return perception_of(self.load_task()[1])

    def request(self) -> ScenarioRequest:
        """Return the scenario with its task."""
        return ScenarioRequest(self.scenario, self.task, self.is_team, self.parameters, self.strict)

    @property
    def first_level(self) -> int:
        """First training level. Runs with different seeds share no levels."""
        return self.seed * SEED_STRIDE

    def to_plain(self) -> dict[str, Any]:
        """Return the settings as plain data."""
        return {
            "scenario": self.scenario,
            "algorithm": self.algorithm,
            "seed": self.seed,
            "parameters": dict(self.parameters),
            "task": self.task,
            "hyperparameters": self.hyperparameters.to_plain(),
            **({} if self.strict else {"strict": False}),
            **({} if self.origin is None else {"from": dict(self.origin)}),
            **({"mixture": [part.to_plain() for part in self.mixture]} if self.mixture else {}),
        }

    @classmethod
    def from_plain(cls, data: dict[str, Any]) -> Self:
        """Make settings from the data of ``to_plain``."""
        values = {name: data[name] for name in ("scenario", "algorithm", "seed", "task")}
        hyper = Hyperparameters.from_plain(data["hyperparameters"])
        others = {"parameters": data.get("parameters", {}), "strict": data.get("strict", True)}
        others["mixture"] = tuple(MixturePart(**part) for part in data.get("mixture", ()))
        return cls(**values, hyperparameters=hyper, origin=data.get("from"), **others)


@dataclass(frozen=True)
class Run(RunFolder):
    """A training run on disk, see ``RunFolder``."""

    @property
    def curve(self) -> Path:
        """File with the scores of the checkpoints."""
        return self.folder / "curve.json"

    def settings(self) -> Settings:
        """Read the settings.

        Raises:
            UnreadableFileError: If the folder holds no run, or its ``config.json`` is another file.
        """
        with reading(self.config, CONFIG_KIND):
            settings = Settings.from_plain(json_object(self.config)["settings"])
            for part in settings.mixture:
                checked(part)
            return checked(settings)

    def begin(self, settings: Settings, now: Snapshot | None = None) -> None:
        """Write the settings, and a copy of the scenario and its task.

        Args:
            now: Snapshot of the scenario and its task; None to take it.
        """
        now = now or settings.snapshot()
        now.write(self.copy)
        copied: dict[str, Any] = {"file": now.file, "sha256": now.digest}
        for k, part in enumerate(settings.parts()[1:], start=2):
            also = part.snapshot()
            also.write(self.copy / str(k))
            copied.setdefault("also", []).append({"folder": str(k), "file": also.file, "sha256": also.digest})
        write_json(self.config, {"settings": settings.to_plain(), "copy": copied, "machine": machine()})

    def change(self, settings: Settings) -> None:
        """Replace the settings on disk; what else stands in ``config.json`` remains."""
        write_json(self.config, {**json_object(self.config), "settings": settings.to_plain()})

    def own_settings(self) -> Settings:
        """Return the settings with the run's own copy in place of the scenario, if there is one.

        Raises:
            IrsimGymError: If the settings or a copy cannot be read.
        """
        settings, copied = self.settings(), self.snapshot()
        if copied is None:
            return settings
        changes: dict[str, Any] = {"task": None, "parameters": _beside(settings.parameters), "mixture": ()}
        files = [self.copy / copied.file, *(folder / also.file for folder, also in self._also())]
        if settings.mixture:
            parts = zip(settings.mixture, files, strict=True)
            changes["mixture"] = tuple(
                MixturePart(str(file.resolve()), _beside(part.parameters), part.share) for part, file in parts
            )
        return replace(settings, scenario=str(files[0].resolve()), **changes)

    def changes_in_others(self, settings: Settings) -> list[str]:
        """Return the changes of a mixture's other scenarios since the start of the run."""
        pairs = zip(self._also(), settings.parts()[1:], settings.names[1:], strict=False)
        differing = [(name, differences(before, part.snapshot())) for (_, before), part, name in pairs]
        return [f"{name}: {change}" for name, changes in differing for change in changes]

    def _also(self) -> Iterator[tuple[Path, Snapshot]]:
        """Yield the folders with copies of a mixture's other scenarios, and their snapshots."""
        with reading(self.config, CONFIG_KIND):
            copies = json_object(self.config)["copy"].get("also", ())
            places = [(self.copy / entry["folder"], str(entry["file"])) for entry in copies]
        for folder, file in places:
            snapshot = read_snapshot(folder, file)
            if snapshot is None:
                raise UnreadableFileError(str(folder / file), "copy of a scenario", "it cannot be read")
            yield folder, snapshot

    def clear(self) -> None:
        """Remove the files of the run. Other files in the folder are kept.

        Raises:
            IrsimGymError: If the folder holds no run.
        """
        self.settings()
        for name in (*FOLDERS, *FILES):
            remove(self.folder / name)


def _beside(parameters: Mapping[str, object]) -> dict[str, object]:
    """Return what a copy of a scenario, in which all parameters are filled in, still takes."""
    return {name: value for name, value in parameters.items() if name in BESIDE}


def _values(parameters: Mapping[str, object]) -> str:
    return "".join(f" {name}={value}" for name, value in parameters.items())


def run_of(policy: str | Path) -> Run:
    """Return the run of a policy, given by the run's folder, or by the file of its policy or of a checkpoint."""
    return Run(folder_of(policy))


def environment_id(scenario: str) -> str:
    """Return the environment id of a scenario, as hyper-parameter files use it."""
    return f"irsim_gym/{Path(scenario_name(scenario)).stem}-v0"
