"""The files of a checkpoint, and the progress that it records. Needs no PyTorch."""

from dataclasses import dataclass, field
from pathlib import Path

from irsim_gym.base.outside_files import checked, json_object, reading, remove

POLICY, NORMALIZATION, PROGRESS = "policy.zip", "vecnormalize.pkl", "progress.json"
STATE, REPLAY_BUFFER = "state.pkl", "replay_buffer.pkl"
PARTIAL = ".partial"
OFF_POLICY = ("sac", "td3", "tqc", "dqn")
"""Algorithms with a replay buffer; each is also the name of the module with its policy classes."""


@dataclass
class RunProgress:
    """Progress of a run.

    Attributes:
        steps: Number of steps taken in all worlds together.
        training_seconds: Wall-clock time of training alone [s], without imports, compilation, checkpoints and scores.
        cpu_seconds: Processor time of training alone [s].
        history: Rows of the training log.
    """

    steps: int = 0
    training_seconds: float = 0.0
    cpu_seconds: float = 0.0
    history: list[dict[str, float]] = field(default_factory=list)


def list_checkpoints(folder: Path) -> list[Path]:
    """Return the complete checkpoints in ``folder``, oldest first."""
    return sorted(path for path in folder.glob("[0-9]*") if (path / POLICY).is_file())


def newest_checkpoint(folder: Path) -> Path | None:
    """Return the newest checkpoint that can be resumed; None if there is none."""
    whole = [path for path in list_checkpoints(folder) if (path / STATE).is_file()]
    return whole[-1] if whole else None


def load_progress(checkpoint: Path) -> RunProgress:
    """Read the progress of a checkpoint.

    Raises:
        UnreadableFileError: It is damaged.
    """
    with reading(checkpoint / PROGRESS, "file with the progress of a training"):
        return checked(RunProgress(**json_object(checkpoint / PROGRESS)))


def remove_partial(folder: Path) -> None:
    """Remove incomplete checkpoints, which a killed process leaves behind."""
    for unfinished in folder.glob(f"{PARTIAL}*"):
        remove(unfinished)


def remove_state(checkpoint: Path) -> None:
    """Remove the state for resuming; keep the policy and its progress."""
    for name in (STATE, REPLAY_BUFFER):
        (checkpoint / name).unlink(missing_ok=True)
