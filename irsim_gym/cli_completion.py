"""What the shell offers for names on the command line; where nothing fits, it offers files by itself."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def scenarios(incomplete: str) -> list[str]:
    """Return the shipped scenarios, and the YAML files here, that begin so."""
    from irsim_gym.scenario.library import every_scenario

    return [*_beginning(incomplete, every_scenario()), *_files(incomplete)]


def tasks(incomplete: str) -> list[str]:
    """Return the shipped tasks, and the YAML files here, that begin so."""
    from irsim_gym.scenario.library import names

    return [*_beginning(incomplete, names("tasks")), *_files(incomplete)]


def algorithms(incomplete: str) -> list[str]:
    """Return the algorithms that begin so."""
    from irsim_gym.training.algorithms import ALGORITHMS

    return _beginning(incomplete, ALGORITHMS)


def splits(incomplete: str) -> list[str]:
    """Return the splits of levels that begin so."""
    from irsim_gym.scenario.level_set import SPLITS

    return _beginning(incomplete, SPLITS)


def policies(incomplete: str) -> list[str]:
    """Return the policies on the shelf, and the runs in ``runs/``, that begin so."""
    from irsim_gym.training.shelf import shelf_files

    runs = sorted(file.parent.as_posix() for file in Path("runs").glob("*/policy.zip"))
    return _beginning(incomplete, ["random", "dash", *shelf_files(), *runs])


def services(incomplete: str) -> list[str]:
    """Return where a log can be sent to, as it begins so."""
    return _beginning(incomplete, ["wandb", "mlflow"])


def _beginning(incomplete: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]


def _files(incomplete: str) -> list[str]:
    """Return the YAML files that begin so, below the folder that is named so far."""
    from irsim_gym.scenario.library import SUFFIXES

    folder, slash, _ = incomplete.rpartition("/")
    place = Path(folder or ("/" if slash else "."))
    found = sorted(file.name for file in place.iterdir() if file.suffix in SUFFIXES) if place.is_dir() else []
    return _beginning(incomplete, [f"{folder}{slash}{name}" for name in found])
