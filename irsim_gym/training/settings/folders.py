"""The default folders of runs, and the differences between two runs."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from irsim_gym.base.compiled.lock import sole
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.requests.folders import as_name, labelled, numbered
from irsim_gym.evaluation.saved_policies.snapshot import Snapshot, differences, listed
from irsim_gym.scenario.text.messages import show
from irsim_gym.training.settings.run import Run, Settings


def default_folder(
    scenario: str,
    algorithm: str,
    seed: int,
    parameters: Mapping[str, object] | None = None,
    team: str | None = None,
    *,
    marks: Sequence[str] = (),
) -> Path:
    """Return the default folder of a run.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        parameters: Values that the user sets for the scenario's parameters.
        team: Team mode; None for a single learner.
        marks: Other differences from the default settings, such as ``steps=500000``.
    """
    parts = [algorithm, *([] if team is None else [team]), *map(as_name, marks), str(seed)]
    return Path("runs") / f"{labelled(scenario, parameters)}-{'-'.join(parts)}"


def free_folder(first: Path, requested: Settings, now: Snapshot) -> tuple[Path, str]:
    """Return the folder of a new run, and a remark on it, which may be empty.

    This is the first of ``first``, ``first-run2`` and so on that holds no run, or a run with the same settings.

    Args:
        first: The preferred folder.
        requested: Settings of the run.
    """
    last: list[str] = []
    for folder in numbered(first, "-run"):
        run = Run(folder)
        if not run.exists():
            return folder, f"{first} holds a run with other settings ({listed(last)}): this one is new" if last else ""
        differing = run_differences(run, requested, now)
        if not differing:
            return folder, ""
        last = last or differing
    raise AssertionError("there is always another number")


def existing_folders(first: Path) -> list[Path]:
    """Return the existing folders of runs with a default name, oldest first."""
    folders: list[Path] = []
    for folder in numbered(first, "-run"):
        if not Run(folder).exists():
            return folders
        folders.append(folder)
    return folders


def run_differences(run: Run, requested: Settings, now: Snapshot) -> list[str]:
    """Return the settings in which a run on disk and a requested one differ, with both values.

    Raises:
        IrsimGymError: If the settings of the run on disk cannot be read.
    """
    before = run.snapshot()
    differing = setting_differences(run.settings(), requested)
    return [*differing, *([] if before is None else [*differences(before, now), *run.changes_in_others(requested)])]


def setting_differences(begun: Settings, requested: Settings) -> list[str]:
    """Return the settings that differ, with both values of each."""
    old, new = (dict(_flat(settings.to_plain(), ())) for settings in (begun, requested))
    names = [name for name in dict.fromkeys([*old, *new]) if old.get(name) != new.get(name)]
    return [f"{name} {show(old.get(name))}, asked for: {show(new.get(name))}" for name in names]


def _flat(data: Mapping[str, object], above: tuple[str, ...]) -> Iterator[tuple[str, Any]]:
    """Yield the values of nested mappings, each with its dotted name."""
    for key, value in data.items():
        place = () if key == "hyperparameters" else (*above, key)
        if isinstance(value, Mapping) and value:
            yield from _flat(value, place)
        else:
            yield ".".join(place), value


@contextmanager
def sole_writer(folder: Path) -> Iterator[None]:
    """Hold a folder for a training of this process. The system ends that with the process, however it ends.

    Raises:
        IrsimGymError: Another process trains into the folder.
    """
    place = folder.resolve()
    new_folders = [folder for folder in place.parents if not folder.exists()]
    place.parent.mkdir(parents=True, exist_ok=True)
    try:
        with sole(place.with_name(f".{place.name}.lock")) as is_free:
            if not is_free:
                raise IrsimGymError(
                    f"another process trains into {folder}: wait for its end, or choose another folder with --out"
                )
            yield
    finally:
        with suppress(OSError):  # folders that hold something stay
            for place_above in new_folders:
                place_above.rmdir()


def check_replaceable(run: Run) -> None:
    """Check that a new run may replace the contents of a folder.

    Raises:
        IrsimGymError: If the folder holds something other than a run.
    """
    is_empty = not run.folder.exists() or (run.folder.is_dir() and not any(run.folder.iterdir()))
    if not run.exists() and not is_empty:
        raise IrsimGymError(f"{run.folder} holds no training run; --overwrite replaces only runs")
