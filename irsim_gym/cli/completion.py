"""Completion of names on the command line. If nothing matches, the shell completes files."""

from collections.abc import Iterable
from pathlib import Path


def scenarios(incomplete: str) -> list[str]:
    """Return the matching shipped scenarios and YAML files."""
    from irsim_gym.scenario.specs.library import every_scenario

    return [*_beginning(incomplete, every_scenario()), *_files(incomplete)]


def tasks(incomplete: str) -> list[str]:
    """Return the matching shipped tasks and YAML files."""
    from irsim_gym.scenario.specs.library import names

    return [*_beginning(incomplete, names("tasks")), *_files(incomplete)]


def algorithms(incomplete: str) -> list[str]:
    """Return the matching algorithms."""
    from irsim_gym.evaluation.saved_policies.algorithms import ALGORITHMS

    return _beginning(incomplete, ALGORITHMS)


def splits(incomplete: str) -> list[str]:
    """Return the matching splits of levels."""
    from irsim_gym.scenario.specs.level_set import SPLITS

    return _beginning(incomplete, SPLITS)


def policies(incomplete: str) -> list[str]:
    """Return the matching shipped policies, behaviours, and finished runs in ``runs/``."""
    from irsim_gym.evaluation.saved_policies.shelf import shelf_files

    runs = sorted(file.parent.as_posix() for file in Path("runs").glob("*/policy.zip"))
    return _beginning(incomplete, ["random", "dash", *shelf_files(), *runs])


def _beginning(incomplete: str, names: Iterable[str]) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]


def _files(incomplete: str) -> list[str]:
    """Return the matching YAML files in the folder that the incomplete text names."""
    from irsim_gym.scenario.specs.library import SUFFIXES

    folder, slash, _ = incomplete.rpartition("/")
    place = Path(folder or ("/" if slash else "."))
    names = sorted(file.name for file in place.iterdir() if file.suffix in SUFFIXES) if place.is_dir() else []
    return _beginning(incomplete, [f"{folder}{slash}{name}" for name in names])
