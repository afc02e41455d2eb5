"""Reads entries of ``robot`` and ``obstacle``; each value is checked once, however many bodies share it."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from irsim_gym.base import families
from irsim_gym.base.errors import suggestion
from irsim_gym.base.options import defaults, option_fields
from irsim_gym.scenario.checking.validation import BAD, Report, build, build_named, check_keys, read_color, read_field
from irsim_gym.scenario.entries.pending import is_pending, read_pending
from irsim_gym.scenario.entries.shorthand import RawEntry, depth, share
from irsim_gym.scenario.specs.image_files import image_problem
from irsim_gym.scenario.specs.library import names
from irsim_gym.scenario.specs.plot_spec import ObjectPlot
from irsim_gym.scenario.specs.spec import MAX_BODIES, BodyOptions, Waypoint
from irsim_gym.scenario.text.messages import choices, show
from irsim_gym.scenario.text.source import Place

FIELDS = option_fields(BodyOptions)
OF_ENTRY = frozenset({"number", "number_range", "distribution"})
SISTERS = {"behavior": "group_behavior", "group_behavior": "behavior"}
"""Keys that are often confused."""
ROBOT, OBSTACLE = "robot", "obstacle"
EVERYONE = "all"
"""Value of ``seen_by`` for a body that all behaviours see."""

NO_DRIVE = "static"
"""Name of a drive for a body that never moves, like one without kinematics."""


@dataclass
class BodyEntry:
    """A checked entry.

    Attributes:
        raw: The entry in the file.
        count: Number of its bodies.
        number_range: Minimum and maximum number of bodies in a level, or None.
        placement: Instance of a distribution; None if it is invalid.
        values: For each key, the checked values that its bodies share, with their paths.
    """

    raw: RawEntry
    count: int = 1
    number_range: tuple[int, int] | None = None
    placement: Any = None
    values: dict[str, list[tuple[Place, Any]]] = field(default_factory=dict)

    def of(self, key: str, i: int) -> tuple[Place, Any]:
        """Return path and value of a key for the entry's i-th body; the default if the key is not given."""
        values = self.values.get(key)
        if not values:
            default = FIELDS[key].default
            return (*self.raw.place, key), default
        return values[min(i, len(values) - 1)]


def read_entry(raw: RawEntry, plot: Mapping[str, object], report: Report) -> BodyEntry:
    """Check all values of an entry.

    Args:
        plot: Drawing options for all bodies of the file; the entry's own options override them.
    """
    entry = BodyEntry(raw)
    spelt = check_keys(raw.data, FIELDS, raw.place, report)
    known = {own: key for key, own in spelt.items()}
    _read_number(entry, report)
    entry.placement = _read_placement(raw, report)
    for own, value in raw.data.items():
        key = known.get(own, own)
        if key not in FIELDS or key in OF_ENTRY or value is None or value == {}:
            continue
        read = _reader(key, raw.role, plot)
        shared = share(key, value, entry.count, (*raw.place, own), report)
        entry.values[key] = [(place, read(item, place, report)) for place, item in shared.values]
    if plot and not entry.values.get("plot"):
        default = build(ObjectPlot, plot, (*raw.place, "plot"), Report(report.source))
        entry.values["plot"] = [((*raw.place, "plot"), default or defaults(ObjectPlot))]
    return entry


def _read_number(entry: BodyEntry, report: Report) -> None:
    data, place = entry.raw.data, entry.raw.place
    number, number_range = data.get("number"), data.get("number_range")
    if number is not None:
        count = read_field(FIELDS["number"], number, (*place, "number"), report)
        entry.count = 1 if count is BAD else count
    if number_range is None:
        return
    if number is not None:
        report.add((*place, "number_range"), "cannot stand beside number")
    bounds = read_field(FIELDS["number_range"], number_range, (*place, "number_range"), report)
    if bounds is BAD:
        return
    low, high = bounds
    if not 0 <= low <= high <= MAX_BODIES or high < 1:
        report.add((*place, "number_range"), f"must be [least, most] with 0 <= least <= most, got {show(bounds)}")
        return
    entry.number_range, entry.count = bounds, high


def _read_placement(raw: RawEntry, report: Report) -> object:
    data, place = raw.data.get("distribution"), (*raw.place, "distribution")
    if data is None or data == {}:
        return families.PLACEMENTS.entry("manual").kind()
    if isinstance(data, Mapping) and "3d" in data:
        if data["3d"] not in (False, None):
            report.add((*place, "3d"), "the world is two-dimensional: only false is allowed")
        data = {key: value for key, value in data.items() if key != "3d"}
    return build_named(families.PLACEMENTS, data, place, report)


def _reader(key: str, role: str, plot: Mapping[str, object]) -> Callable[[Any, Place, Report], Any]:
    """Return the function that checks one value of a key."""
    if key in families.KINDS_OF_BODIES:
        return lambda value, place, report: _read_kind(key, value, place, report)
    if key == "disturbances" and role != ROBOT:
        return _refuse_disturbances
    if key == "plot":
        return lambda value, place, report: _read_plot(value, plot, place, report)
    if key == "role":
        return lambda value, place, report: _read_role(value, role, place, report)
    return READERS.get(key) or (lambda value, place, report: read_field(FIELDS[key], value, place, report))


def _read_kind(key: str, value: Any, place: Place, report: Report) -> object:
    if value is None or value == {}:
        return None
    name = value.get("name") if isinstance(value, Mapping) else None
    if key == "kinematics" and isinstance(name, str) and name not in families.KINEMATICS:
        if name.lower() == NO_DRIVE:
            check_keys(value, ["name"], place, report)
            return None
        value = {**value, "name": name.lower() if name.lower() in families.KINEMATICS else name}
    if key == "shape" and isinstance(value, Mapping) and name is None:
        value = _named_shape(value, place, report)
    own, sister = families.BY_KEY[key], families.BY_KEY.get(SISTERS.get(key, ""), ())
    if isinstance(name, str) and name not in own and name in sister:
        report.add((*place, "name"), f"'{name}' is a {SISTERS[key]}: write `{SISTERS[key]}: {{name: {name}}}`")
        return BAD
    if key == "group_behavior" and isinstance(name, str) and name not in families.GROUP_BEHAVIORS:
        report.could_be_lenient = True
        if not report.strict:
            why = "each member decides by itself, as in IR-SIM 2.12.0"
            report.doubt(place, f"no group behavior named {show(name)}: {why}")
            return None
    if report.may_pend and is_pending(key, value):
        made: Any = read_pending(key, value, place, report)
    else:
        made = build_named(own, value, place, report)
    return BAD if made is None else made


def _named_shape(shape: Mapping[str, Any], place: Place, report: Report) -> Mapping[str, Any]:
    """Return a shape with a name if the reader is not strict: IR-SIM takes one without for a circle."""
    if not set(shape) <= {"name", *option_fields(families.FOOTPRINTS.entry("circle").kind)}:
        return shape
    report.could_be_lenient = True
    if report.strict:
        return shape
    report.doubt(place, "a shape without a name is a circle, as in IR-SIM 2.12.0")
    return {**shape, "name": "circle"}


def _read_sensors(value: object, place: Place, report: Report) -> object:
    items = [value] if isinstance(value, Mapping) else value
    if not isinstance(items, list):
        report.add(place, f"must be a list of sensors such as [{{name: lidar2d}}], got {show(value)}")
        return BAD
    paths = [place] if isinstance(value, Mapping) else [(*place, i) for i in range(len(items))]
    made = [_read_sensor(item, where, report) for item, where in zip(items, paths, strict=True)]
    return BAD if any(sensor is None for sensor in made) else tuple(made)


def _read_sensor(item: object, place: Place, report: Report) -> object:
    return build_named(families.SENSORS, item, place, report, default="lidar2d", synonym="type")


def _refuse_disturbances(value: object, place: Place, report: Report) -> object:
    report.add(place, "only robots have disturbances")
    return BAD


def read_disturbances(value: object, place: Place, report: Report) -> object:
    """Return the disturbances of a list of mappings; BAD after reporting problems."""
    if not isinstance(value, list):
        report.add(place, f"must be a list of disturbances such as [{{name: latency, time: 0.2}}], got {show(value)}")
        return BAD
    made = [build_named(families.DISTURBANCES, item, (*place, i), report) for i, item in enumerate(value)]
    return BAD if any(one is None for one in made) else tuple(made)


def _read_goal(value: Any, place: Place, report: Report) -> object:
    if value is None:
        return ()
    levels = depth(value)
    if levels == 0:
        report.add(place, f"must be [x, y] or [x, y, heading], got {show(value)}")
        return BAD
    goals = [(place, value)] if levels == 1 else [((*place, i), goal) for i, goal in enumerate(value)]
    read = [_read_waypoint(goal, where, report) for where, goal in goals]
    return BAD if any(goal is BAD for goal in read) else tuple(read)


def _read_waypoint(value: object, place: Place, report: Report) -> object:
    numbers = read_field(FIELDS["state"], value, place, report)
    if numbers is BAD:
        return BAD
    if len(numbers) < 2:
        report.add(place, f"must be [x, y] or [x, y, heading], got {show(value)}")
        return BAD
    waypoint: Waypoint = (numbers[0], numbers[1], numbers[2] if len(numbers) > 2 else math.nan)
    return waypoint


def _read_plot(value: Any, shared: Mapping[str, Any], place: Place, report: Report) -> object:
    own = build(ObjectPlot, value, place, report)
    if own is None or not shared:
        return BAD if own is None else own
    return build(ObjectPlot, {**shared, **value}, place, Report(report.source)) or own


def _read_role(value: object, role: str, place: Place, report: Report) -> object:
    if value != role:
        report.add(place, f"must be '{role}' in this section (or left out), got {show(value)}")
        return BAD
    return value


def _read_seen_by(value: object, place: Place, report: Report) -> object:
    if value == EVERYONE:
        return None
    return read_field(FIELDS["seen_by"], [value] if isinstance(value, str) else value, place, report)


def _read_color(value: object, place: Place, report: Report) -> object:
    return value if value == "cycle" else read_color(FIELDS["color"], value, place, report)


def _read_description(value: object, place: Place, report: Report) -> object:
    image = read_field(FIELDS["description"], value, place, report)
    problem = "" if image is BAD or image is None else image_problem(image, report.source.file)
    if problem:
        report.add(place, problem)
    return BAD if problem else image


def _read_preset(value: object, place: Place, report: Report) -> object:
    """Report a name that is not shipped: the keys of shipped robots are there in its place."""
    shipped = names("robots")
    near = suggestion(str(value)[:40], shipped)
    report.add(place, f"no robot named {show(value)}{near}; it must be {choices(shipped)}")
    return BAD


def _read_mass(key: str, value: object, place: Place, report: Report) -> object:
    """Return a number that may be infinite; IR-SIM takes the word ``inf`` for one."""
    is_infinite = isinstance(value, str) and value.lower().removeprefix("+") in ("inf", "infinity")
    return read_field(FIELDS[key], math.inf if is_infinite else value, place, report)


READERS: dict[str, Callable[[Any, Place, Report], Any]] = {
    "sensors": _read_sensors,
    "disturbances": read_disturbances,
    "goal": _read_goal,
    "seen_by": _read_seen_by,
    "color": _read_color,
    "description": _read_description,
    "preset": _read_preset,
    "mass": lambda value, place, report: _read_mass("mass", value, place, report),
    "inertia": lambda value, place, report: _read_mass("inertia", value, place, report),
}
