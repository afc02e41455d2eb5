"""Snapshots of a scenario and its task at the start of a run: loadable copies, and the changes since then.

A copy is self-contained: parameters are replaced by their values, the task is a single file, and images are in the same
folder, with the hash of their contents in their names.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from irsim_gym.envs.gymnasium.worlds import TaskSource
from irsim_gym.evaluation.protocol.tables import write_bytes, write_text
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.reading.map_cells import find_map
from irsim_gym.scenario.reading.ros_map import SUFFIXES, read_ros_map
from irsim_gym.scenario.specs.library import asset
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.source import ROLES, WRAPPER, read_file
from irsim_gym.tasks.definition.task import merged_task

TASKS = "tasks"
DRAWN = frozenset({"plot", "gui", "color", "description", "sample_time"})
"""Keys that only affect drawing."""
MAX_SHOWN = 4
"""Largest number of differences that a message lists."""
MISSING = "nothing"
"""Text for a missing value."""

Keys = tuple[str | int, ...]
"""Path of a value in nested mappings and lists."""


@dataclass(frozen=True)
class Snapshot:
    """A scenario and its task as plain data.

    Attributes:
        file: Name of the scenario's file.
        task_name: Name of the task.
        scenario: Sections of the file, without ``parameters`` and ``task``.
        task: The complete task, merged from its files and the scenario's section.
        pictures: Images, levels and recordings that the scenario refers to, by their names in the copy.
    """

    file: str
    task_name: str
    scenario: Mapping[str, object]
    task: Mapping[str, object]
    pictures: Mapping[str, Path] = field(default_factory=dict)

    @property
    def digest(self) -> str:
        """SHA-256 hash of all values that affect learning, in hexadecimal digits."""
        text = json.dumps([[list(place), value] for place, value in sorted(self.values().items(), key=str)])
        return hashlib.sha256(text.encode()).hexdigest()

    def values(self) -> dict[Keys, Any]:
        """Return the values that affect learning, by their paths."""
        sections = {**self.scenario, "task": self.task}
        return dict(_leaves(sections, ()))

    def write(self, folder: Path) -> None:
        """Write the copy: the scenario's file, its task in ``tasks/``, and the files that it refers to."""
        task_file = f"{TASKS}/{self.task_name}.yaml"
        for name, file in self.pictures.items():
            write_bytes(folder / name, file.read_bytes())
        write_text(folder / task_file, _yaml({"name": "blank", **self.task}))
        write_text(folder / self.file, _yaml({**self.scenario, "task": task_file}))


def take_snapshot(
    scenario: str, task: str | None, parameters: Mapping[str, object] | None = None, *, strict: bool = True
) -> Snapshot:
    """Take a snapshot of a scenario and its task.

    Args:
        scenario: Shipped name, or path of a scenario file.
        task: Shipped name or path of a task; None for the scenario's own.

    Raises:
        IrsimGymError: If the scenario or the task is invalid.
    """
    return snapshot_of(load_scenario(scenario, parameters, strict=strict, warn=False), task)


def snapshot_of(loaded: Scenario, task: TaskSource) -> Snapshot:
    """Take a snapshot of a loaded scenario and a task, which is a name, a path, plain data, or None for its own."""
    name, merged = merged_task(loaded, task)
    sections = _sections(loaded.source.data)
    pictures: dict[str, Path] = {}
    _copy_map(loaded, sections, pictures)
    if loaded.levels is not None:
        sections["levels"] = _add_file(Path(loaded.levels.file), pictures)
    for role in ROLES:
        entries = [_with_pictures(entry, loaded.file, pictures) for entry in sections.get(role, [])]
        sections[role] = [_with_recording(entry, loaded.file, pictures) for entry in entries]
    plain = {key: value for key, value in sections.items() if key not in ("task", "parameters") and value != []}
    task_data = {key: value for key, value in merged.items() if key != "name"}
    return Snapshot(Path(loaded.file).name, name, plain, task_data, pictures)


def read_snapshot(folder: Path, file: str) -> Snapshot | None:
    """Read a copy that ``Snapshot.write`` wrote; return None if it cannot be read."""
    try:
        scenario = dict(read_file(folder / file).data)
        task_file = folder / scenario.pop("task")
        task = {key: value for key, value in read_file(task_file).data.items() if key != "name"}
    except (ValueError, OSError, KeyError, TypeError, AttributeError):
        return None
    return Snapshot(file, task_file.stem, scenario, task)


def differences(before: Snapshot, now: Snapshot) -> list[str]:
    """Return the values that have changed: ``world.step_time 0.1, now 0.2``."""
    old, new = before.values(), now.values()
    places = [place for place in dict.fromkeys([*old, *new]) if _plain(old.get(place)) != _plain(new.get(place))]
    return [f"{dotted_keys(place)} {_shown(place, old)}, now {_shown(place, new)}" for place in places]


def dotted_keys(place: Keys) -> str:
    """Return the path of a value as text: ``robot[0].vel_max``."""
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text


def listed(found: list[str]) -> str:
    """Return the first differences of a list as text, and the number of further ones."""
    more = len(found) - MAX_SHOWN
    return "; ".join([*found[:MAX_SHOWN], *([f"and {more} more"] if more > 0 else [])])


def _shown(place: Keys, values: Mapping[Keys, Any]) -> str:
    return show(values[place]) if place in values else MISSING


def _plain(value: object) -> Any:
    return value if not isinstance(value, tuple) else list(value)


def _yaml(data: Mapping[str, object]) -> str:
    return yaml.safe_dump(dict(data), sort_keys=False, allow_unicode=True, width=120)


def _sections(data: object) -> dict[str, Any]:
    """Return the sections of a file, including those inside the wrapper key, with robots and obstacles as lists."""
    outer = dict(data) if isinstance(data, Mapping) else {}
    inner = outer.pop(WRAPPER, None)
    sections = {**outer, **(inner if isinstance(inner, Mapping) else {})}
    for role in ROLES:
        entries = sections.get(role)
        sections[role] = [entries] if isinstance(entries, Mapping) else list(entries or [])
    return sections


def _leaves(value: object, place: Keys) -> Iterator[tuple[Keys, Any]]:
    """Yield all values with their paths. A list without mappings is one value. Terms of the task are keyed by name."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            if key not in DRAWN:
                yield from _leaves(item, (*place, key))
    elif isinstance(value, list) and any(isinstance(item, Mapping) for item in value):
        for i, item in enumerate(value):
            name = item.get("name") if isinstance(item, Mapping) and place[0] == "task" else None
            yield from _leaves(item, (*place, name if isinstance(name, str) else i))
    else:
        yield place, value


def _copy_map(loaded: Scenario, sections: dict[str, Any], pictures: dict[str, Path]) -> None:
    """Add the image of the obstacle map, if it has one, to the copy, and refer to it in ``sections``."""
    made = loaded.world.obstacle_map
    path = getattr(made, "path", None)
    world = sections.get("world")
    if not isinstance(path, str) or not isinstance(world, Mapping):
        return
    file = find_map(path, (Path(loaded.file).parent,))
    name = _add_ros_map(file, pictures) if file.suffix in SUFFIXES else _add_file(file, pictures)
    given = world.get("obstacle_map")
    sections["world"] = {**world, "obstacle_map": {**given, "path": name} if isinstance(given, Mapping) else name}


def _add_ros_map(file: Path, pictures: dict[str, Path]) -> str:
    """Add a map of ROS with its image, in a folder of their own, and return the name of its file in the copy."""
    found = read_ros_map(file)
    folder = f"{file.stem}-{hashlib.sha256(file.read_bytes() + found.image.read_bytes()).hexdigest()[:12]}"
    pictures[f"{folder}/{file.name}"] = file
    if not Path(found.content.image).is_absolute():
        pictures[f"{folder}/{found.content.image}"] = found.image
    return f"{folder}/{file.name}"


def _with_pictures(entry: object, file: str, pictures: dict[str, Path]) -> Any:
    """Return an entry that refers to images in the copy."""
    if not isinstance(entry, Mapping) or "description" not in entry:
        return entry

    def added(name: object) -> Any:
        return _add_file(asset("images", name, file), pictures) if isinstance(name, str) else name

    given = entry["description"]
    return {**entry, "description": [added(one) for one in given] if isinstance(given, list) else added(given)}


def _with_recording(entry: object, file: str, pictures: dict[str, Path]) -> Any:
    """Return an entry that refers to a recording in the copy."""
    behavior = entry.get("behavior") if isinstance(entry, Mapping) else None
    if not isinstance(entry, Mapping) or not isinstance(behavior, Mapping) or behavior.get("name") != "recorded":
        return entry
    return {**entry, "behavior": {**behavior, "file": _add_file(asset("recordings", behavior["file"], file), pictures)}}


def _add_file(file: Path, pictures: dict[str, Path]) -> str:
    """Add a file to the copy, and return its name there, which contains a hash of its contents."""
    content = hashlib.sha256(file.read_bytes()).hexdigest()[:12]
    name = f"{file.stem}-{content}{file.suffix}"
    pictures[name] = file
    return name
