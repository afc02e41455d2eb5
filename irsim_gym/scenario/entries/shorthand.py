"""IR-SIM's short forms: sections that are a list or a mapping, and lists of values for the bodies of an entry."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from irsim_gym.scenario.checking.validation import Report, read_numbers
from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.source import WRAPPER, Place

VECTORS = frozenset({"state", "velocity", "vel_min", "vel_max", "acce", "angle_range"})
SCALARS = frozenset({"goal_threshold", "fov", "fov_radius", "group", "state_dim", "vel_dim", "static", "unobstructed"})
OWN_EACH = frozenset({"mass", "friction", "inertia", "restitution"})
"""Keys of which a list of numbers holds one for each body."""


@dataclass(frozen=True)
class RawEntry:
    """An entry of ``robot`` or ``obstacle`` as in the file."""

    role: str
    place: Place
    data: Mapping[str, object]


@dataclass(frozen=True)
class Shared:
    """The values of one key for the bodies of an entry: body i has the i-th value, or else the last.

    Attributes:
        values: Path and value of each element.
    """

    values: tuple[tuple[Place, Any], ...]


def split_sections(data: object, report: Report) -> tuple[dict[str, Any], dict[str, Place]]:
    """Return the sections of a file by name, and the path of the wrapper key around each."""
    if not isinstance(data, Mapping):
        report.add((), f"must be a mapping with sections such as world, robot and obstacle, got {show(data)}")
        return {}, {}
    sections: dict[str, Any] = dict(data)
    roots: dict[str, Place] = dict.fromkeys(sections, ())
    if WRAPPER in sections:
        inner = sections.pop(WRAPPER)
        if not isinstance(inner, Mapping | None):
            report.add((WRAPPER,), f"must be a mapping with sections such as world and robot, got {show(inner)}")
        for name, section in (inner if isinstance(inner, Mapping) else {}).items():
            if name in sections:
                report.add((WRAPPER, name), "given both inside and outside the wrapper key")
            sections[name], roots[name] = section, (WRAPPER,)
    return sections, roots


def split_entries(role: str, section: object, place: Place, report: Report) -> list[RawEntry]:
    """Return the entries of a section, which is a list of mappings, one mapping, or None."""
    if section is None:
        return []
    if isinstance(section, Mapping):
        return [RawEntry(role, place, section)]
    if not isinstance(section, list):
        report.add(place, f"must be a list of {role}s or one mapping, got {show(section)}")
        return []
    entries = []
    for i, data in enumerate(section):
        if isinstance(data, Mapping):
            entries.append(RawEntry(role, (*place, i), data))
        else:
            report.add((*place, i), f"must be a mapping of options, got {show(data)}")
    return entries


def share(key: str, value: object, count: int, place: Place, report: Report) -> Shared:
    """Distribute the value of one key of an entry over its ``count`` bodies.

    A list of numbers is one vector for all bodies. Any other list holds one value per body; its last value also applies
    to the remaining bodies. For keys that take a single number, a list of ``count`` numbers holds one per body.
    """
    if key == "goal":
        return _share_goals(read_numbers(value), count, place)
    if key in ("sensors", "disturbances"):
        return _share_lists(value, count, place)
    if key in ("seen_by", "preset"):
        return Shared(((place, value),))
    if key in VECTORS or key in SCALARS:
        value = read_numbers(value)
    is_vector = key in VECTORS and isinstance(value, list) and not any(isinstance(item, list) for item in value)
    if not isinstance(value, list) or is_vector:
        return Shared(((place, value),))
    if key in OWN_EACH:
        return _one_each(value, count, place) if value else Shared(((place, value),))
    if key in SCALARS:
        if len(value) == count:
            return _one_each(value, count, place)
        report.add(place, f"must be one value, or a list of {count} (one per body), got {show(value)}")
        return Shared(())
    if all(isinstance(item, int | float) for item in value):
        return Shared(((place, value),))
    return _one_each(value, count, place)


def _one_each(value: list[Any], count: int, place: Place) -> Shared:
    return Shared(tuple(((*place, i), item) for i, item in enumerate(value[:count])))


def _share_lists(value: object, count: int, place: Place) -> Shared:
    """Distribute sensors or disturbances: a list of mappings is for all bodies, a list of lists has one per body."""
    if isinstance(value, list) and value and not all(isinstance(item, Mapping) for item in value):
        return _one_each(value, count, place)
    return Shared(((place, value),))


def _share_goals(value: Any, count: int, place: Place) -> Shared:
    """Distribute goals: one goal is for all bodies; two levels of lists hold one goal per body, three levels several.

    For a single body, two levels hold its goals in order.
    """
    levels = depth(value)
    if levels <= 1 or (levels == 2 and count == 1):
        return Shared(((place, value),))
    return _one_each(value, count, place)


def depth(value: object, most: int = 4) -> int:
    """Return the number of nested lists around the numbers, at most ``most``."""
    if not isinstance(value, list) or most == 0:
        return 0
    return 1 + max((depth(item, most - 1) for item in value), default=0)
