"""Reads a YAML file as plain data, with the line of every value."""

import stat
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from irsim_gym.base.errors import Problem, ScenarioError, suggestion
from irsim_gym.scenario.text.composer import MAX_DEPTH, MAX_VALUES, Fatal, compose

Place = tuple[str | int, ...]

WRAPPER = "irsim"
ROLES = ("robot", "obstacle")
SECTIONS = ("world", *ROLES, "gui", "plot", "task", "levels", "custom", "parameters")

MAX_BYTES = 2 * 1024 * 1024
LONGEST_KEY = 60


class MissingFileError(ScenarioError, FileNotFoundError):
    """A scenario file that does not exist."""


@dataclass(frozen=True)
class Source:
    """Plain data with the lines of its values.

    Attributes:
        file: The given path; empty for a mapping made in Python.
        data: Dictionaries with text keys, lists, text, numbers, booleans and None.
        lines: Line of each value by its path, counted from 1; empty for a mapping.
        problems: Mistakes found while reading.
        repeats: Each repeated key, and whether it is a section or holds further keys; ``data`` holds the last value.
        ignored: Unused keys found so far.
        unknown: Paths of values that could not be evaluated, which ``problems`` reports.
        origins: Original text of values with parameters, by path.
    """

    file: str
    data: Any
    lines: Mapping[Place, int] = field(default_factory=dict)
    problems: tuple[Problem, ...] = ()
    repeats: tuple[tuple[Problem, bool], ...] = ()
    ignored: tuple[Problem, ...] = ()
    unknown: frozenset[Place] = frozenset()
    origins: Mapping[Place, str] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """The name of the source in error messages."""
        return self.file or "the given mapping"

    def line(self, place: Place) -> int:
        """Return the line of a value, or of the nearest enclosing one if it is not in the file; 0 if unknown."""
        for length in range(len(place), -1, -1):
            if place[:length] in self.lines:
                return self.lines[place[:length]]
        return 0

    def problem(self, place: Place, message: str) -> Problem:
        """Return a problem at a path, with its line, and with the original text if the value used a parameter."""
        origin = self.origins.get(place)
        full = message if origin is None else f"{message} (from {' '.join(origin[:LONGEST_KEY].split())})"
        return Problem(self.line(place), dotted(place), full)


def is_section(place: Place) -> bool:
    """Return whether a path is that of a whole section, possibly within the wrapper key."""
    return len(place) == 1 or (len(place) == 2 and place[0] == WRAPPER)


def dotted(place: Place) -> str:
    """Return a path as text: ``robot[0].shape.radius``."""
    text = ""
    for part in place:
        part = part[:LONGEST_KEY] if isinstance(part, str) else part
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def read_file(file: str | Path) -> Source:
    """Read a YAML file.

    Raises:
        ScenarioError: If the file cannot be read, is not YAML, or exceeds a bound (size, depth, number of values).
    """
    name = str(file)
    raw = _bytes(Path(file), name)
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise ScenarioError(name, [Problem(line, "", f"not UTF-8 text (byte 0x{raw[error.start]:02x})")]) from None
    try:
        document = compose(text)
    except Fatal as error:
        raise ScenarioError(name, [Problem(error.line, "", str(error))]) from None
    problems = tuple(Problem(line, dotted(place), message) for line, place, message in document.problems)
    repeats = tuple(
        (Problem(line, dotted(place), message), is_block or is_section(place))
        for line, place, message, is_block in document.repeats
    )
    return Source(name, document.data, document.lines, problems, repeats)


def _bytes(path: Path, name: str) -> bytes:
    """Return the content of a file after checking its type and size."""
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise ScenarioError(name, [Problem(0, "", "is a directory, not a YAML file")])
        if not stat.S_ISREG(status.st_mode):
            raise ScenarioError(name, [Problem(0, "", "is not a regular file")])
        if status.st_size > MAX_BYTES:
            size = f"{status.st_size / 1e6:.1f} MB"
            raise ScenarioError(name, [Problem(0, "", f"too large: {size}, at most {MAX_BYTES / 1e6:.1f} MB")])
        return path.read_bytes()
    except FileNotFoundError:
        raise MissingFileError(name, [Problem(0, "", f"no such file{_neighbor(path)}")]) from None
    except (OSError, ValueError) as error:
        if isinstance(error, ScenarioError):
            raise
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise ScenarioError(name, [Problem(0, "", f"cannot be read: {reason}")]) from None


def _neighbor(path: Path) -> str:
    """Return a hint that names the file most similar to a missing one."""
    folder = path.parent
    if not folder.is_dir():
        return f": there is no folder {folder}"
    return suggestion(path.name, [file.name for file in folder.iterdir() if file.suffix in (".yaml", ".yml")])


def read_mapping(data: Mapping[str, object]) -> Source:
    """Convert data made in Python: tuples and NumPy values become lists and numbers.

    Raises:
        ScenarioError: If the data is nested too deeply (or contains itself), is too large, or holds other objects.
    """
    problems: list[Problem] = []
    budget = [MAX_VALUES]
    plain = _plain(data, (), problems, budget)
    return Source("", plain, {}, tuple(problems))


def _plain(value: object, place: Place, problems: list[Problem], budget: list[int]) -> object:
    budget[0] -= 1
    if len(place) > MAX_DEPTH or budget[0] < 0:
        limit = f"nested deeper than {MAX_DEPTH} levels" if budget[0] >= 0 else f"more than {MAX_VALUES} values"
        raise ScenarioError("the given mapping", [Problem(0, dotted(place[:3]), limit)])
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
        if place[-1:] == ("obstacle_map",):
            return value  # the many cells of a map are plain already
    if isinstance(value, Mapping):
        return _plain_mapping(value, place, problems, budget)
    if isinstance(value, list | tuple):
        return [_plain(item, (*place, i), problems, budget) for i, item in enumerate(value)]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Path):
        return str(value)
    problems.append(Problem(0, dotted(place), f"must be plain data, got an object of type {type(value).__name__}"))
    return None


def _plain_mapping(value: Mapping[Any, Any], place: Place, problems: list[Problem], budget: list[int]) -> object:
    plain = {}
    for key, item in value.items():
        if isinstance(key, str):
            plain[key] = _plain(item, (*place, key), problems, budget)
        else:
            problems.append(Problem(0, dotted(place), f"keys must be text, got {str(key)[:40]}"))
    return plain
