"""Makes bodies from checked entries: fills in defaults, and runs the checks that need several keys."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from irsim_gym.base.families import FOOTPRINTS, KINEMATICS, PLACEMENTS
from irsim_gym.scenario.checking.validation import BAD, Report
from irsim_gym.scenario.entries import body_checks
from irsim_gym.scenario.entries.entries import FIELDS, OBSTACLE, OF_ENTRY, BodyEntry
from irsim_gym.scenario.specs import plot_spec
from irsim_gym.scenario.specs.image_files import DEFAULT_CAR
from irsim_gym.scenario.specs.spec import BodySpec, PlacementSpec, Waypoint
from irsim_gym.scenario.specs.world_spec import WorldSpec
from irsim_gym.scenario.text.source import Place

AS_WRITTEN = (
    *("kinematics", "behavior", "group_behavior", "goal", "goal_threshold", "arrive_mode", "unobstructed"),
    *("description", "plot", "seen_by", "speed_range", "unyielding", "party"),
    *("friction", "inertia", "restitution"),
)
"""Keys of an entry that are fields of its bodies, with the same values."""


def make_bodies(entry: BodyEntry, index: int, first: int, group: int, report: Report) -> list[BodySpec]:
    """Return the bodies of an entry; an empty list if one of its values is invalid.

    Args:
        index: Index of its placement.
        first: Number of its first body.
        group: Group of its bodies if it names none.
    """
    patterns: dict[tuple[int, ...], BodySpec | None] = {}
    bodies = []
    for i in range(entry.count):
        choice = tuple(min(i, len(values) - 1) for key, values in entry.values.items() if key not in ("name", "color"))
        if choice not in patterns:
            patterns[choice] = _pattern(entry, i, index, group, report)
        pattern = patterns[choice]
        if pattern is not None:
            bodies.append(_named(pattern, entry, i, first + i))
    return bodies if len(bodies) == entry.count else []


def _named(pattern: BodySpec, entry: BodyEntry, i: int, number: int) -> BodySpec:
    name, color = name_of(entry, i, number)[1], entry.of("color", i)[1]
    if color == "cycle":
        color = plot_spec.CYCLE[i % len(plot_spec.CYCLE)]
    elif color is None or color is BAD:
        image = pattern.description or _default_image(pattern)
        return replace(pattern, name=name, color=_default_color(pattern), description=image)
    return replace(pattern, name=name, color=color)


def name_of(entry: BodyEntry, i: int, number: int) -> tuple[Place, str]:
    """Return path and name of the entry's i-th body, which is body ``number`` of the scenario."""
    place, name = entry.of("name", i)
    return place, f"{entry.raw.role}_{number}" if name is None or name is BAD else name


def _default_color(body: BodySpec) -> str:
    if body.coasts:
        return plot_spec.COASTING_COLOR
    if body.role == OBSTACLE:
        return plot_spec.OBSTACLE_COLOR if body.static else plot_spec.MOVING_OBSTACLE_COLOR
    return plot_spec.CAR_COLOR if _is_car(body) else plot_spec.ROBOT_COLOR


def _default_image(body: BodySpec) -> str | None:
    """Return the default image of a car whose entry sets no looks; None for other bodies."""
    plot = body.plot
    is_plain = plot.obj_color is None and plot.obj_linewidth is None and plot.obj_linestyle in ("-", "solid")
    is_box = FOOTPRINTS.name_of(type(body.shape)) == "rectangle"
    return DEFAULT_CAR if body.role != OBSTACLE and _is_car(body) and is_box and is_plain else None


def _is_car(body: BodySpec) -> bool:
    return body.kinematics is not None and KINEMATICS.name_of(type(body.kinematics)) == "acker"


def _pattern(entry: BodyEntry, i: int, index: int, group: int, report: Report) -> BodySpec | None:
    """Return the entry's i-th body without name and colour, after the checks that need several keys."""
    fields = {key: entry.of(key, i) for key in FIELDS if key not in OF_ENTRY}
    values = {key: value for key, (_, value) in fields.items()}
    places = {key: place for key, (place, _) in fields.items()}
    drive = values["kinematics"]
    good = body_checks.check_body(values, places, report)
    if not good or entry.placement is None:
        return None
    low = float(values["angle_range"][0])
    mass = values["mass"] or (math.inf if drive is None or values["static"] else 1.0)
    is_static = values["static"] or (drive is None and mass == math.inf)
    size = 3 if drive is None and not is_static else body_checks.command_size(drive)
    role: Any = entry.raw.role
    fastest = _drawn_speeds(values)
    own_group = group if values["group"] is None else values["group"]
    is_given = bool(entry.values.get("state"))
    fov, fov_radius = body_checks.field_of_view(values["fov"], values["fov_radius"], values["sensors"] or ())
    return BodySpec(
        name="",
        role=role,
        entry=index,
        line=report.source.line(entry.raw.place),
        shape=values["shape"] or FOOTPRINTS.entry("circle").kind(),
        sensors=values["sensors"] or (),
        disturbances=values["disturbances"] or (),
        state=None if getattr(entry.placement, "gives_goal", False) and not is_given else _pose(values["state"]),
        steering=_padded(values["state"], 4, 0.0)[3],
        velocity=_padded(values["velocity"], size, 0.0),
        vel_min=_padded(values["vel_min"] or tuple(-speed for speed in fastest), size, -1.0),
        vel_max=_padded((*fastest, *(values["vel_max"] or ())[len(fastest) :]), size, 1.0),
        acce=_padded(values["acce"] or (), size, math.inf),
        angle_range=(low, low + 2.0 * math.pi),
        static=is_static,
        mass=mass,
        group=own_group,
        group_name=values["group_name"] or f"{role}_{own_group}",
        color="",
        fov=fov,
        fov_radius=fov_radius,
        **{key: values[key] for key in AS_WRITTEN},
    )


def _drawn_speeds(values: Mapping[str, Any]) -> tuple[float, ...]:
    """Return the upper bound of ``speed_range`` for each velocity of the drive that is a speed; empty without one."""
    if values["speed_range"] is None or values["kinematics"] is None:
        return ()
    return (float(values["speed_range"][1]),) * body_checks.speed_count(values["kinematics"])


def _pose(state: tuple[float, ...]) -> Waypoint:
    x, y, heading = _padded(state, 3, 0.0)
    return x, y, heading


def _padded(values: tuple[float, ...], size: int, default: float) -> tuple[float, ...]:
    return (*values, *[default] * size)[:size]


def placement_of(entry: BodyEntry, first: int, report: Report) -> PlacementSpec:
    """Return the placement of the entry's bodies."""
    members = tuple(range(first, first + entry.count))
    role: Any = entry.raw.role
    return PlacementSpec(members, entry.placement, entry.number_range, role, report.source.line(entry.raw.place))


def with_map(
    world: WorldSpec, bodies: tuple[BodySpec, ...], placements: tuple[PlacementSpec, ...], line: int
) -> tuple[tuple[BodySpec, ...], tuple[PlacementSpec, ...]]:
    """Return bodies and placements with the obstacle map as last body: a fixed obstacle in its own group."""
    names, number = {body.name for body in bodies}, len(bodies)
    name = f"{OBSTACLE}_{number}"
    while name in names:
        name += "_map"
    group = 1 + max((body.group for body in bodies), default=-1)
    look: dict[str, Any] = {"group": group, "group_name": f"{OBSTACLE}_{group}", "color": plot_spec.MAP_COLOR}
    look |= {"shape": world.obstacle_map, "static": True}
    body = BodySpec(name=name, role="obstacle", entry=len(placements), line=line, **look)
    placement = PlacementSpec((number,), PLACEMENTS.entry("manual").kind(), None, "obstacle", line)
    return (*bodies, body), (*placements, placement)
