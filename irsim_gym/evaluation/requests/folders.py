"""Where evaluations and pictures are written, by default and on request."""

import re
from collections.abc import Iterator, Mapping
from itertools import count
from pathlib import Path

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.scenario.specs.ids import scenario_name

RESULTS = ("summary.json", "episodes.csv", "levels.csv", "table.txt")
"""Files that an evaluation writes."""


def evaluation_folder(
    scenario: str,
    split: str,
    parameters: Mapping[str, object] | None = None,
    team: bool = False,
    *,
    overwrite: bool = False,
    kind: str = "evaluation",
) -> Path:
    """Return the default folder of an evaluation or an arena.

    This is the first numbered folder without results; with ``overwrite`` the first one.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        parameters: Values that the user sets for the scenario's parameters.
        team: Whether whole teams are evaluated.
        overwrite: Replace existing results.
        kind: ``evaluation``, ``arena`` or ``robustness``.
    """
    whose = "-team" if team else ""
    first = Path("runs") / f"{kind}-{labelled(scenario, parameters)}{whose}-{split}"
    return next(folder for folder in numbered(first) if overwrite or not has_results(folder))


def has_results(folder: Path) -> bool:
    """Return whether a folder holds results of an evaluation."""
    return any((folder / name).exists() for name in RESULTS)


def check_no_results(folder: Path | None, overwrite: bool) -> None:
    """Check that results may be written to a folder: it holds none, or they are replaced on purpose.

    Raises:
        IrsimGymError: If it holds results.
    """
    if folder is not None and has_results(folder) and not overwrite:
        raise IrsimGymError(f"{folder} holds results: choose another with --out, or replace them with --overwrite")


def check_free(file: Path | None, overwrite: bool = False) -> None:
    """Check that a file may be written: it does not exist, or is replaced on purpose; None for no file.

    Raises:
        IrsimGymError: If it exists.
    """
    if file is not None and file.exists() and not overwrite:
        raise IrsimGymError(f"{file} exists: choose another name with --out, or replace it with --overwrite")


def free_file(first: Path, overwrite: bool = False) -> Path:
    """Return the first of ``film.mp4``, ``film-2.mp4`` and so on that does not exist; with ``overwrite`` the first."""
    names = (path.with_suffix(first.suffix) for path in numbered(first.with_suffix("")))
    return first if overwrite else next(file for file in names if not file.exists())


def labelled(scenario: str, parameters: Mapping[str, object] | None = None) -> str:
    """Return the name of a scenario with the values of its parameters, for use in a file name."""
    values = "".join(f"-{name}={value}" for name, value in (parameters or {}).items())
    return as_name(f"{Path(scenario_name(scenario)).stem}{values}")


def as_name(text: str) -> str:
    """Return text for use in a file name: other characters become underscores."""
    return re.sub(r"[^\w.=-]", "_", text)


def numbered(first: Path, before: str = "-") -> Iterator[Path]:
    """Yield a folder, and then the folder with the numbers 2, 3 and so on appended."""
    yield first
    for number in count(2):
        yield first.with_name(f"{first.name}{before}{number}")
