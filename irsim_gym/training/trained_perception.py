"""The perception of a trained policy: the observations and the action of its training."""

from __future__ import annotations

from pathlib import Path

from irsim_gym.errors import IrsimGymError, UnknownPerceptionWarning, warn_caller
from irsim_gym.evaluation.perception import Perception, perception_of
from irsim_gym.training.run import Settings, run_of


def trained_perception(policy: str | Path) -> Perception | None:
    """Return the perception of a policy's training; None for a file outside a run's folder.

    It is read from the run's copy of its scenario and task. If this fails, an ``UnknownPerceptionWarning`` gives the
    reason, and the result is None.

    Args:
        policy: A run's folder, or the file of a policy in it.
    """
    run = run_of(policy)
    if not run.exists():
        return None
    try:
        return perception_in(run.own_settings())
    except IrsimGymError as error:
        text = f"{run.folder}: the observations of its training cannot be read, so its policy uses those of the task"
        warn_caller(f"{text}: {error}", UnknownPerceptionWarning)
        return None


def perception_in(settings: Settings) -> Perception:
    """Return the perception of a policy that is trained with the given settings.

    Raises:
        IrsimGymError: If the scenario or its task cannot be read.
    """
    return perception_of(settings.load_task()[1])
