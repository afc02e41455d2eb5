"""The folder of a training run, as far as those need it who play its policy."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from irsim_gym.base.errors import UnreadableFileError
from irsim_gym.base.outside_files import checked, json_object, reading
from irsim_gym.evaluation.policies.perception import Perception, perception_of
from irsim_gym.evaluation.saved_policies.snapshot import Snapshot, read_snapshot
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.specs.library import SUFFIXES
from irsim_gym.tasks import load_task

CONFIG_KIND = "file with the settings of a training run"


@dataclass(frozen=True)
class Trained:
    """What a policy was trained in.

    Attributes:
        scenario: Shipped name, or path of a scenario file.
        task: Shipped name or path of a task; None for the scenario's own.
        parameters: Values of the scenario's parameters.
        strict: Whether unused keys of the scenario are an error.
        team: Team mode; None for a single learner.
        steps: Steps of the whole run.
        mixture: All scenarios of the training with their parameters; empty for a single scenario.
    """

    scenario: str
    task: str | None
    parameters: Mapping[str, object]
    strict: bool
    team: str | None
    steps: int
    mixture: tuple[tuple[str, Mapping[str, object]], ...] = field(default=())

    @property
    def parts(self) -> tuple[tuple[str, Mapping[str, object]], ...]:
        """Each scenario with its parameters."""
        return self.mixture or ((self.scenario, self.parameters),)


@dataclass(frozen=True)
class RunFolder:
    """The folder of a training run.

    Attributes:
        folder: The folder, which may not exist yet.
    """

    folder: Path

    @property
    def config(self) -> Path:
        """File with the settings, and with the machine and the versions of packages."""
        return self.folder / "config.json"

    @property
    def copy(self) -> Path:
        """Folder with a copy of the scenario and its task."""
        return self.folder / "scenario"

    @property
    def checkpoints(self) -> Path:
        """Folder with a folder for each checkpoint, named after its number of steps."""
        return self.folder / "checkpoints"

    @property
    def policy(self) -> Path:
        """File of the final policy. It only exists if the run is finished."""
        return self.folder / "policy.zip"

    def exists(self) -> bool:
        """Return whether the folder holds a run."""
        return self.config.is_file()

    def finished(self) -> bool:
        """Return whether the run has taken all its steps."""
        return self.policy.is_file()

    def trained(self) -> Trained:
        """Read what the policy is trained in.

        Raises:
            UnreadableFileError: If the folder holds no run, or its ``config.json`` is another file.
        """
        with reading(self.config, CONFIG_KIND):
            data: dict[str, Any] = json_object(self.config)["settings"]
            learning = data["hyperparameters"]
            mixture = tuple((part["scenario"], part["parameters"]) for part in data.get("mixture", ()))
            parameters, strict = data.get("parameters", {}), data.get("strict", True)
            team, steps = learning.get("team"), learning["n_timesteps"]
            return checked(Trained(data["scenario"], data["task"], parameters, strict, team, steps, mixture))

    def snapshot(self) -> Snapshot | None:
        """Return the snapshot of the scenario and its task from the start of the run; None if the run has no copy."""
        try:
            with reading(self.config, CONFIG_KIND):
                file = str(json_object(self.config)["copy"]["file"])
        except UnreadableFileError:
            return None
        return read_snapshot(self.copy, file)

    def perception(self) -> Perception:
        """Return what the policy perceives in the training, by the run's own copy of its scenario if there is one.

        Raises:
            IrsimGymError: If the settings or the scenario cannot be read.
        """
        trained, copied = self.trained(), self.snapshot()
        if copied is None:
            scenario = load_scenario(trained.scenario, trained.parameters, strict=trained.strict, warn=False)
        else:
            scenario = load_scenario(str((self.copy / copied.file).resolve()), strict=trained.strict, warn=False)
        task = trained.task if copied is None else None
        return perception_of(load_task(scenario, task, team=trained.team is not None))


def folder_of(policy: str | Path) -> Path:
    """Return the folder of a policy's run, given by that folder, or by the file of its policy or of a checkpoint."""
    path = Path(policy)
    folder = path if path.is_dir() else path.parent
    return folder.parent.parent if folder.parent.name == "checkpoints" else folder


def lasting(source: str) -> str:
    """Return the absolute path of a file, so that a run can be resumed from another folder; return names unchanged."""
    return str(Path(source).resolve()) if Path(source).suffix in (*SUFFIXES, ".npz") else source
