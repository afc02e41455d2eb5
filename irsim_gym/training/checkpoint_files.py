"""Which files a checkpoint has, and how far it is; needs no PyTorch."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass, field
from pathlib import Path

POLICY, NORMALIZATION, PROGRESS = "policy.zip", "vecnormalize.pkl", "progress.json"
STATE, REPLAY_BUFFER = "state.pkl", "replay_buffer.pkl"
PARTIAL = ".partial"


@dataclass
class RunProgress:
    """How far a run has come.

    Attributes:
        steps: Steps taken, over all worlds.
        training_seconds: Wall-clock time of training alone [s]: no imports, compilation, checkpoints or scores.
        cpu_seconds: Processor time of the same [s].
        history: Rows of the training log.
    """

    steps: int = 0
    training_seconds: float = 0.0
    cpu_seconds: float = 0.0
    history: list[dict[str, float]] = field(default_factory=list)


def list_checkpoints(folder: Path) -> list[Path]:
    """Return the whole checkpoints below ``folder``, oldest first."""
    return sorted(path for path in folder.glob("[0-9]*") if (path / POLICY).is_file())


def newest_checkpoint(folder: Path) -> Path | None:
    """Return the newest checkpoint that can be resumed; None when there is none."""
    whole = [path for path in list_checkpoints(folder) if (path / STATE).is_file()]
    return whole[-1] if whole else None


def load_progress(checkpoint: Path) -> RunProgress:
    """Read how far a checkpoint is."""
    return RunProgress(**json.loads((checkpoint / PROGRESS).read_text(encoding="utf-8")))


def remove_partial(folder: Path) -> None:
    """Remove checkpoints that a killed process left half written."""
    for unfinished in folder.glob(f"{PARTIAL}*"):
        shutil.rmtree(unfinished)


def forget_state(checkpoint: Path) -> None:
    """Remove what resuming needs; the policy and its progress stay."""
    for name in (STATE, REPLAY_BUFFER):
        (checkpoint / name).unlink(missing_ok=True)
