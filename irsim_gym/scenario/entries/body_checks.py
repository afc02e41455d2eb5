"""Checks that involve several keys of a body."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from irsim_gym.base.families import BEHAVIORS, GROUP_BEHAVIORS, KINEMATICS, commands, steers
from irsim_gym.base.registry import Registry
from irsim_gym.scenario.checking.validation import BAD, Report
from irsim_gym.scenario.text.messages import choices, show
from irsim_gym.scenario.text.source import Place

FULL_TURN = 2.0 * math.pi
TURN_TOLERANCE = 0.01
"""Tolerance for the width of a full turn [rad]: [-3.14, 3.14] counts as one."""

TURNS = ("angular", "steer")
"""Velocities of drives that are not speeds."""

SCANNER = "add sensors: [{name: lidar2d}] to it"
"""Advice if a scan is missing."""

CURE = "add kinematics or remove the {key}"

DECIDING: Mapping[str, Registry] = {"behavior": BEHAVIORS, "group_behavior": GROUP_BEHAVIORS}
Values = Mapping[str, Any]
Places = Mapping[str, Place]


def command_size(drive: Any) -> int:
    """Return the number of velocities of a drive; 2 for a body without one."""
    return 2 if drive is None else len(drive.command_names)


def speed_count(drive: Any) -> int:
    """Return the number of a drive's velocities that are speeds [m/s]; they come first."""
    return 0 if drive is None else sum(name not in TURNS for name in drive.command_names)


def check_body(values: Values, places: Places, report: Report) -> bool:
    """Run each check whose values are readable; return whether all values are readable and all checks pass."""
    needs = {
        check_drive: ("kinematics", "behavior", "group_behavior", "static", "mass"),
        check_scan: ("kinematics", "behavior", "group_behavior", "static", "sensors"),
        check_dimensions: ("kinematics", "state_dim", "vel_dim", "vel_min", "vel_max", "acce", "velocity"),
        check_limits: ("kinematics", "vel_min", "vel_max"),
        check_speeds: ("kinematics", "speed_range", "static"),
        check_angle_range: ("angle_range",),
        check_wheelbase: ("kinematics", "shape", "static"),
        check_view: ("sensors", "fov", "fov_radius"),
    }
    n_problems = len(report.problems)
    for check, keys in needs.items():
        if all(values[key] is not BAD for key in keys):
            check(values, places, report)
    return len(report.problems) == n_problems and all(value is not BAD for value in values.values())


def check_drive(values: Values, places: Places, report: Report) -> None:
    """Report a behaviour that cannot drive the body's kinematics; a body without kinematics is only a doubt."""
    drive = values["kinematics"]
    for key, registry in DECIDING.items():
        behavior = values[key]
        if behavior is None or values["static"]:
            continue
        if drive is None and (values["mass"] or math.inf) < math.inf:
            report.add(places[key], f"a body that coasts (a mass, no drive) decides nothing: {CURE.format(key=key)}")
        elif drive is None:
            report.doubt(places[key], f"the body has no kinematics, so it stands still: {CURE.format(key=key)}")
        elif not commands(behavior, type(drive)) and not steers(behavior, type(drive)):
            name, drives = KINEMATICS.name_of(type(drive)), choices(behavior.kinematics)
            behavior_name = registry.name_of(type(behavior))
            report.add(places[key], f"'{behavior_name}' cannot drive kinematics '{name}'; it drives {drives}")


def check_scan(values: Values, places: Places, report: Report) -> None:
    """Report a behaviour that reads its body's scan if the body has no range sensor."""
    if values["static"] or values["kinematics"] is None or has_range_sensor(values["sensors"] or ()):
        return
    for key, registry in DECIDING.items():
        if getattr(values[key], "reads_scan", False):
            name = registry.name_of(type(values[key]))
            report.add(places[key], f"'{name}' reads the body's own scan, but the body has no range sensor; {SCANNER}")


def has_range_sensor(sensors: Sequence[object]) -> bool:
    """Return whether one of the sensors is a range sensor that behaviours can read, which must have angles."""
    return any(getattr(sensor, "reading", "") == "ranges" and hasattr(sensor, "angles") for sensor in sensors)


def check_dimensions(values: Values, places: Places, report: Report) -> None:
    """Report vectors of the wrong length, and dimensions that differ from the drive's."""
    drive = values["kinematics"]
    name = "a body without kinematics" if drive is None else f"'{KINEMATICS.name_of(type(drive))}'"
    size, state_size = command_size(drive), 3 if drive is None else drive.state_size
    if values["state_dim"] not in (None, state_size):
        report.add(places["state_dim"], f"must be {state_size} for {name}, got {show(values['state_dim'])}")
    if drive is None:
        return
    if values["vel_dim"] not in (None, size):
        report.add(places["vel_dim"], f"must be {size} for {name}, got {show(values['vel_dim'])}")
    meaning = ", ".join(drive.command_names)
    for key in ("vel_min", "vel_max", "acce"):
        if values[key] is not None and len(values[key]) != size:
            report.add(places[key], f"must have {size} numbers ({meaning}) for {name}, got {show(values[key])}")
    if len(values["velocity"]) > size:
        message = f"must have at most {size} numbers ({meaning}) for {name}, got {show(values['velocity'])}"
        report.add(places["velocity"], message)


def check_limits(values: Values, places: Places, report: Report) -> None:
    """Report limits that allow no velocity."""
    size = command_size(values["kinematics"])
    low, high = values["vel_min"] or (-1.0,) * size, values["vel_max"] or (1.0,) * size
    if values["kinematics"] is not None and any(a > b for a, b in zip(low, high, strict=False)):
        key = "vel_min" if values["vel_min"] is not None else "vel_max"
        report.add(places[key], f"vel_min must not exceed vel_max, got {show(low)} and {show(high)}")


def check_speeds(values: Values, places: Places, report: Report) -> None:
    """Report a range of speeds that is invalid, or that the drive does not use."""
    if values["speed_range"] is None:
        return
    place, (low, high), drive = places["speed_range"], values["speed_range"], values["kinematics"]
    if not 0.0 <= low <= high:
        report.add(place, f"must be [low, high] with 0 <= low <= high, got {show(values['speed_range'])}")
    elif drive is None or values["static"]:
        report.doubt(place, f"the body never moves: {CURE.format(key='speed_range')}")
    elif not hasattr(drive, "drive"):
        name = KINEMATICS.name_of(type(drive))
        report.add(place, f"works with diff, omni, omni_angular and acker, not with kinematics '{name}'")


def check_angle_range(values: Values, places: Places, report: Report) -> None:
    """Report an interval of headings that is not a full turn."""
    low, high = values["angle_range"]
    if abs(high - low - FULL_TURN) > TURN_TOLERANCE:
        message = f"must be a full turn wide (2 pi), such as [-pi, pi], got {show(values['angle_range'])}"
        report.add(places["angle_range"], message)


def check_wheelbase(values: Values, places: Places, report: Report) -> None:
    """Report a drive that needs a wheelbase if neither it nor the shape gives one."""
    drive, shape = values["kinematics"], values["shape"]
    is_needed = not values["static"] and getattr(drive, "needs_wheelbase", False)
    if is_needed and drive.wheelbase is None and not getattr(shape, "wheelbase", None):
        message = f"is required for '{KINEMATICS.name_of(type(drive))}', here or in the shape: the axle distance"
        report.add((*places["kinematics"], "wheelbase"), message)


def check_view(values: Values, places: Places, report: Report) -> None:
    """Report a field of view with only one of width and depth, given or from a range sensor."""
    fov, radius = field_of_view(values["fov"], values["fov_radius"], values["sensors"] or ())
    if (fov is None) != (radius is None):
        present, missing = ("fov", "fov_radius") if radius is None else ("fov_radius", "fov")
        report.add(places[present], f"needs {missing} too, or a lidar that defines it")


def field_of_view(fov: float | None, radius: float | None, sensors: Sequence[Any]) -> tuple[float | None, float | None]:
    """Return width [rad] and depth [m] of a field of view; None is replaced by the value of the first range sensor."""
    lidar = next((sensor for sensor in sensors if getattr(sensor, "reading", "") == "ranges"), None)
    if lidar is not None:
        fov = lidar.angle_range if fov is None else fov
        radius = lidar.range_max if radius is None else radius
    return None if fov is None else min(fov, FULL_TURN), radius
