"""A scenario and its task as they were when a run began: a copy that can be loaded, and what has changed since.

The copy refers to nothing outside of it: values are in the places of parameters, the task is one file, and pictures lie
beside it under names that tell their content.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from irsim_gym.envs.worlds import TaskSource
from irsim_gym.evaluation.tables import write_bytes, write_text
from irsim_gym.scenario.image_files import image_file
from irsim_gym.scenario.load import load_scenario
from irsim_gym.scenario.map_cells import find_map
from irsim_gym.scenario.messages import show
from irsim_gym.scenario.recorded_bodies import find_recording
from irsim_gym.scenario.source import ROLES, WRAPPER, read_file
from irsim_gym.scenario.spec import Scenario
from irsim_gym.tasks.task import merged_task

TASKS = "tasks"
DRAWN = frozenset({"plot", "gui", "color", "description", "sample_time"})
"""Keys that matter to pictures alone."""
MOST_KEYS = 4
LEFT_OUT = "nothing"

Keys = tuple[str | int, ...]


@dataclass(frozen=True)
class Snapshot:
    """What is learned, and where, as plain data.

    Attributes:
        file: Name of the scenario's file.
        task_name: Name of the task.
        scenario: The file's sections, without parameters and the section ``task``.
        task: All that the task's files and the scenario's section say, laid over each other.
        pictures: Pictures and levels that the scenario refers to, by their names in the copy.
    """

    file: str
    task_name: str
    scenario: Mapping[str, object]
    task: Mapping[str, object]
    pictures: Mapping[str, Path] = field(default_factory=dict)

    @property
    def digest(self) -> str:
        """SHA-256 of all that matters to learning, in hexadecimal digits."""
        text = json.dumps([[list(place), value] for place, value in sorted(self.values().items(), key=str)])
        return hashlib.sha256(text.encode()).hexdigest()

    def values(self) -> dict[Keys, Any]:
        """Return the values that matter to learning, by the path of their keys."""
        sections = {**self.scenario, "task": self.task}
        return dict(_leaves(sections, ()))

    def write(self, folder: Path) -> None:
        """Write the copy: the scenario's file, its task below ``tasks/``, and its pictures."""
        task_file = f"{TASKS}/{self.task_name}.yaml"
        for name, file in self.pictures.items():
            write_bytes(folder / name, file.read_bytes())
        write_text(folder / task_file, _yaml({"name": "blank", **self.task}))
        write_text(folder / self.file, _yaml({**self.scenario, "task": task_file}))


def take_snapshot(
    scenario: str, task: str | None, parameters: Mapping[str, object] | None = None, *, strict: bool = True
) -> Snapshot:
    """Return how a scenario and its task are now.

    Args:
        scenario: Shipped name, or path of a scenario file.
        task: Shipped name or path of a task; None for the scenario's own.
        parameters: Values for the scenario's parameters.
        strict: False ignores unused keys.

    Raises:
        IrsimGymError: They cannot be used.
    """
    return snapshot_of(load_scenario(scenario, parameters, strict=strict, warn=False), task)


def snapshot_of(loaded: Scenario, task: TaskSource) -> Snapshot:
    """Return how a loaded scenario and a task (a name, a path, plain data, None for the scenario's own) are now."""
    name, merged = merged_task(loaded, task)
    sections = _sections(loaded.source.data)
    pictures: dict[str, Path] = {}
    _take_map(loaded, sections, pictures)
    if loaded.levels is not None:
        sections["levels"] = _kept(Path(loaded.levels.file), pictures)
    for role in ROLES:
        entries = [_with_pictures(entry, loaded.file, pictures) for entry in sections.get(role, [])]
        sections[role] = [_with_recording(entry, loaded.file, pictures) for entry in entries]
    plain = {key: value for key, value in sections.items() if key not in ("task", "parameters") and value != []}
    task_data = {key: value for key, value in merged.items() if key != "name"}
    return Snapshot(Path(loaded.file).name, name, plain, task_data, pictures)


def read_snapshot(folder: Path, file: str) -> Snapshot | None:
    """Return a copy that ``write`` made; None where it cannot be read."""
    try:
        scenario = dict(read_file(folder / file).data)
        task_file = folder / scenario.pop("task")
        task = {key: value for key, value in read_file(task_file).data.items() if key != "name"}
    except (ValueError, OSError, KeyError, TypeError, AttributeError):
        return None
    return Snapshot(file, task_file.stem, scenario, task)


def differences(before: Snapshot, now: Snapshot) -> list[str]:
    """Return which values have changed: ``world.step_time 0.1, now 0.2``."""
    old, new = before.values(), now.values()
    places = [place for place in dict.fromkeys([*old, *new]) if _plain(old.get(place)) != _plain(new.get(place))]
    return [f"{dotted_keys(place)} {_shown(place, old)}, now {_shown(place, new)}" for place in places]


def dotted_keys(place: Keys) -> str:
    """Return the path of a value, ``robot[0].vel_max``."""
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text


def listed(found: list[str]) -> str:
    """Return the first of several differences, and how many more there are."""
    more = len(found) - MOST_KEYS
    return "; ".join([*found[:MOST_KEYS], *([f"and {more} more"] if more > 0 else [])])


def _shown(place: Keys, values: Mapping[Keys, Any]) -> str:
    return show(values[place]) if place in values else LEFT_OUT


def _plain(value: object) -> Any:
    return value if not isinstance(value, tuple) else list(value)


def _yaml(data: Mapping[str, object]) -> str:
    return yaml.safe_dump(dict(data), sort_keys=False, allow_unicode=True, width=120)


def _sections(data: object) -> dict[str, Any]:
    """Return the sections of a file, those inside the wrapper key too; robots and obstacles are lists."""
    outer = dict(data) if isinstance(data, Mapping) else {}
    inner = outer.pop(WRAPPER, None)
    sections = {**outer, **(inner if isinstance(inner, Mapping) else {})}
    for role in ROLES:
        entries = sections.get(role)
        sections[role] = [entries] if isinstance(entries, Mapping) else list(entries or [])
    return sections


def _leaves(value: object, place: Keys) -> Iterator[tuple[Keys, Any]]:
    """Yield the values that are no mappings; a list without mappings is one value. A task's terms go by their names."""
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


def _take_map(loaded: Scenario, sections: dict[str, Any], pictures: dict[str, Path]) -> None:
    """Let the copy's obstacle map, where it is a picture, refer to a picture beside it."""
    made = loaded.world.obstacle_map
    path = getattr(made, "path", None)
    world = sections.get("world")
    if not isinstance(path, str) or not isinstance(world, Mapping):
        return
    file = find_map(path, (Path(loaded.file).parent,))
    name = _kept(file, pictures)
    given = world.get("obstacle_map")
    sections["world"] = {**world, "obstacle_map": {**given, "path": name} if isinstance(given, Mapping) else name}


def _with_pictures(entry: object, file: str, pictures: dict[str, Path]) -> Any:
    """Return an entry whose images lie beside the copy."""
    if not isinstance(entry, Mapping) or "description" not in entry:
        return entry

    def kept(name: object) -> Any:
        return _kept(image_file(name, file), pictures) if isinstance(name, str) else name

    given = entry["description"]
    return {**entry, "description": [kept(one) for one in given] if isinstance(given, list) else kept(given)}


def _with_recording(entry: object, file: str, pictures: dict[str, Path]) -> Any:
    """Return an entry whose recording lies beside the copy."""
    behavior = entry.get("behavior") if isinstance(entry, Mapping) else None
    if not isinstance(entry, Mapping) or not isinstance(behavior, Mapping) or behavior.get("name") != "recorded":
        return entry
    return {**entry, "behavior": {**behavior, "file": _kept(find_recording(behavior["file"], file), pictures)}}


def _kept(file: Path, pictures: dict[str, Path]) -> str:
    """Return the name under which the copy finds a picture: its content is part of the name."""
    content = hashlib.sha256(file.read_bytes()).hexdigest()[:12]
    name = f"{file.stem}-{content}{file.suffix}"
    pictures[name] = file
    return name
