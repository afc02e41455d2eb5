"""Reads recorded pedestrians: text files with rows of time, id, x, y, like those of ETH and UCY."""

import math
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.errors import UnreadableFileError
from irsim_gym.base.outside_files import reading
from irsim_gym.scenario.text.messages import show

COLUMNS = 4
MOST_STEPS = 1_000_000


class BadRecordingError(ValueError):
    """A file that cannot be read as a recording; the message names the line, the value and what is expected."""


class PersonTracks(NamedTuple):
    """The content of a recording.

    Attributes:
        persons: Ids in the order of the file.
        tracks: Rows of time (in the file's unit), x, y [m] of each person, times ascending, shape ``(n, 3)``.
        first: The earliest time in the file.
    """

    persons: tuple[int, ...]
    tracks: tuple[NDArray[np.float64], ...]
    first: float


def read_recording(file: Path) -> PersonTracks:
    """Read a file with rows of four numbers, time, id, x and y, separated by spaces, tabs or commas.

    Empty lines and lines that begin with # are skipped. Rows may be in any order.

    Raises:
        BadRecordingError: If the file is not a recording; the message names the line and what is wrong with it.
    """
    stamp = file.stat().st_mtime_ns if file.is_file() else 0
    return _read(file, stamp)


@lru_cache(maxsize=16)
def _read(file: Path, stamp: int) -> PersonTracks:
    rows: dict[int, dict[float, tuple[float, float]]] = {}
    lines: dict[tuple[int, float], int] = {}
    try:
        with reading(file, "recording"):
            text = file.read_text(encoding="utf-8")
    except UnreadableFileError as error:
        raise BadRecordingError(error.reason) from None
    for number, line in enumerate(text.splitlines(), start=1):
        cells = line.replace(",", " ").split()
        if not cells or cells[0].startswith("#"):
            continue
        time, person, x, y = _numbers(cells, number, line)
        if (person, time) in lines:
            raise BadRecordingError(
                f"line {number}: person {person} is at two places at the time {time:g}, see line {lines[person, time]}"
            )
        lines[person, time] = number
        rows.setdefault(person, {})[time] = x, y
    if not rows:
        raise BadRecordingError("holds no rows: each must be time, id, x, y, such as 0.4 1 3.25 -1.5")
    tracks = tuple(np.array([(t, *points[t]) for t in sorted(points)]) for points in rows.values())
    return PersonTracks(tuple(rows), tracks, min(float(track[0, 0]) for track in tracks))


def _numbers(cells: Sequence[str], number: int, line: str) -> tuple[float, int, float, float]:
    shown = show(line.strip()[:60])
    if len(cells) != COLUMNS:
        raise BadRecordingError(f"line {number}: must have 4 numbers, time, id, x, y, got {len(cells)}: {shown}")
    try:
        time, person, x, y = map(float, cells)
    except ValueError:
        raise BadRecordingError(f"line {number}: must have 4 numbers, time, id, x, y, got {shown}") from None
    if not all(map(math.isfinite, (time, person, x, y))) or person != int(person):
        raise BadRecordingError(f"line {number}: must have finite numbers and a whole id, got {shown}")
    return time, int(person), x, y


def sampled(options: Any, step_time: float) -> NDArray[np.float64]:
    """Return a person's position at each step [m], interpolated linearly; NaN if it is absent, shape ``(n, 2)``.

    Row k is at the time ``start_time + k * step_time``; the last row is after the person has left.

    Args:
        options: A behaviour ``recorded`` with its person.
        step_time: Duration of a step [s].
    """
    recording = read_recording(Path(options.file))
    track = recording.tracks[recording.persons.index(options.person)]
    times = (track[:, 0] - recording.first) * options.time_unit - options.start_time
    last = min(max(math.ceil(times[-1] / step_time), 0), MOST_STEPS)
    at = np.arange(last + 2) * step_time
    points = np.stack([np.interp(at, times, track[:, 1 + axis]) + options.offset[axis] for axis in range(2)], axis=1)
    points[(at < times[0] - 1e-9) | (at > times[-1] + 1e-9)] = np.nan
    return points
