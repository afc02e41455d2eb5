"""Where runs and evaluations lie that were given no folder, and how two runs differ."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import Any

from irsim_gym.errors import IrsimGymError
from irsim_gym.scenario.messages import show
from irsim_gym.training.run import Run, Settings, scenario_name
from irsim_gym.training.snapshot import Snapshot, differences, listed

RESULTS = ("summary.json", "episodes.csv", "levels.csv", "table.txt")
"""Files of an evaluation."""


def default_folder(
    scenario: str,
    algorithm: str,
    seed: int,
    parameters: Mapping[str, object] | None = None,
    team: str | None = None,
    *,
    marks: Sequence[str] = (),
) -> Path:
    """Return the folder of a run that was given none.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        algorithm: The algorithm.
        seed: The seed.
        parameters: Values that were given for the scenario's parameters.
        team: The team's mode.
        marks: What else differs from the usual settings, such as ``steps=500000``.
    """
    parts = [algorithm, *([] if team is None else [team]), *map(as_name, marks), str(seed)]
    return Path("runs") / f"{labelled(scenario, parameters)}-{'-'.join(parts)}"


def evaluation_folder(
    scenario: str,
    split: str,
    parameters: Mapping[str, object] | None = None,
    team: bool = False,
    *,
    overwrite: bool = False,
    resume: bool = False,
    kind: str = "evaluation",
) -> Path:
    """Return the folder of an evaluation, or of an arena, that was given none.

    It is one that holds no results yet; to overwrite it is the first one, and to resume the last one with results.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        split: Split of the levels.
        parameters: Values that were given for the scenario's parameters.
        team: Whole teams play.
        overwrite: Replace an existing run.
        resume: Continue an existing run.
        kind: ``evaluation`` or ``arena``.
    """
    whose = "-team" if team else ""
    first = last = Path("runs") / f"{kind}-{labelled(scenario, parameters)}{whose}-{split}"
    for folder in _numbered(first):
        if overwrite or not has_results(folder):
            return last if resume else folder
        last = folder
    raise AssertionError("there is always another number")


def has_results(folder: Path) -> bool:
    """Return whether an evaluation wrote into a folder."""
    return any((folder / name).exists() for name in RESULTS)


def labelled(scenario: str, parameters: Mapping[str, object] | None = None) -> str:
    """Return the name of a scenario with its given parameters, as part of a file's name."""
    given = "".join(f"-{name}={value}" for name, value in (parameters or {}).items())
    return as_name(f"{Path(scenario_name(scenario)).stem}{given}")


def as_name(text: str) -> str:
    """Return text as part of a file's name."""
    return re.sub(r"[^\w.=-]", "_", text)


def free_folder(first: Path, asked: Settings, now: Snapshot) -> tuple[Path, str]:
    """Return the folder of a new run, and a remark on it.

    It is the one that holds this very run, if there is one, else the first of ``first``, ``first-run2`` and so on that
    holds none.

    Args:
        first: Where it would lie.
        asked: What it trains.
        now: The scenario and its task.
    """
    last: list[str] = []
    for folder in _numbered(first, "-run"):
        run = Run(folder)
        if not run.exists():
            return folder, f"{first} holds a run with other settings ({listed(last)}): this one is new" if last else ""
        found = run_differences(run, asked, now)
        if not found:
            return folder, ""
        last = last or found
    raise AssertionError("there is always another number")


def begun_folders(first: Path) -> list[Path]:
    """Return the folders of runs with a default name, the oldest first."""
    found: list[Path] = []
    for folder in _numbered(first, "-run"):
        if not Run(folder).exists():
            return found
        found.append(folder)
    return found


def _numbered(first: Path, before: str = "-") -> Iterator[Path]:
    yield first
    for number in count(2):
        yield first.with_name(f"{first.name}{before}{number}")


def run_differences(run: Run, asked: Settings, now: Snapshot) -> list[str]:
    """Return the settings in which a run on disk and a requested one differ, with both values.

    Raises:
        IrsimGymError: The folder's settings cannot be read.
    """
    before = run.snapshot()
    found = setting_differences(run.settings(), asked)
    return [*found, *([] if before is None else [*differences(before, now), *run.changes_in_others(asked)])]


def setting_differences(begun: Settings, asked: Settings) -> list[str]:
    """Return the settings that differ, both values of each."""
    old, new = (dict(_flat(settings.to_plain(), ())) for settings in (begun, asked))
    names = [name for name in dict.fromkeys([*old, *new]) if old.get(name) != new.get(name)]
    return [f"{name} {show(old.get(name))}, asked for: {show(new.get(name))}" for name in names]


def _flat(data: Mapping[str, object], above: tuple[str, ...]) -> Iterator[tuple[str, Any]]:
    for key, value in data.items():
        place = () if key == "hyperparameters" else (*above, key)
        if isinstance(value, Mapping) and value:
            yield from _flat(value, place)
        else:
            yield ".".join(place), value


def replaceable(run: Run) -> None:
    """Make sure that a new run may take the place of what is in a folder.

    Raises:
        IrsimGymError: There is something else than a run.
    """
    is_empty = not run.folder.exists() or (run.folder.is_dir() and not any(run.folder.iterdir()))
    if not run.exists() and not is_empty:
        raise IrsimGymError(f"{run.folder} holds no training run; --overwrite replaces only runs")
