"""Values that are allowed but seldom meant: ``irsim-gym check`` mentions them."""

from __future__ import annotations

import math
from collections.abc import Iterator

from irsim_gym.errors import Problem
from irsim_gym.families import KINEMATICS
from irsim_gym.scenario.shorthand import ROLES, split_entries
from irsim_gym.scenario.source import Place
from irsim_gym.scenario.spec import BodySpec, Scenario
from irsim_gym.scenario.validation import Report, read_numbers

FULL_TURN = 2.0 * math.pi + 1e-3
LONGEST_STEP = 1.0
DEGREES = "angles are radians; pi/2 may be written as it is"


def notes(scenario: Scenario) -> tuple[Problem, ...]:
    """Return what is worth a second look in a scenario, in the order of its lines; nothing of it is an error."""
    found = [*_world_notes(scenario), *_view_notes(scenario)]
    for body in scenario.bodies:
        found += [Problem(body.line, body.name, message) for message in _body_notes(body, scenario)]
    seen: dict[tuple[int, str], Problem] = {}
    for note in found:
        seen.setdefault((note.line, note.message), note)
    return tuple(sorted(seen.values()))


def _world_notes(scenario: Scenario) -> Iterator[Problem]:
    world = scenario.world
    if world.step_time > LONGEST_STEP:
        yield scenario.problem(
            ("world", "step_time"), f"{world.step_time:g} s is a long step: bodies may jump through walls"
        )


def _view_notes(scenario: Scenario) -> Iterator[Problem]:
    """Look at ``fov`` as it stands in the file: a body's own is a full turn at most."""
    root: Place = scenario.root.get("robot", ()) or scenario.root.get("obstacle", ())
    sections = scenario.source.data[root[0]] if root else scenario.source.data
    for role in ROLES:
        for entry in split_entries(role, (sections or {}).get(role), (*root, role), Report(scenario.source)):
            value = read_numbers(entry.data.get("fov"))
            for width in value if isinstance(value, list) else [value]:
                if width is not None and width > FULL_TURN:
                    yield scenario.source.problem(
                        (*entry.place, "fov"), f"fov of {width:g} is more than a turn: {DEGREES}"
                    )


def _body_notes(body: BodySpec, scenario: Scenario) -> Iterator[str]:
    yield from _angle_notes(body)
    if body.kinematics is None or body.static:
        return
    drive = KINEMATICS.name_of(type(body.kinematics))
    speed = body.vel_max[0] if drive in ("diff", "acker") else max(body.vel_max[:2])
    stride = speed * scenario.world.step_time
    if body.goal and stride > 2.0 * body.goal_threshold:
        yield (
            f"a step of {stride:g} m may jump over a goal_threshold of {body.goal_threshold:g} m: "
            "make one larger or the other smaller"
        )
    decides = body.behavior or body.group_behavior
    places = bool(body.goal) or scenario.placements[body.entry].kind.gives_goal
    if decides and not places and not getattr(body.behavior, "wander", False):
        yield "has a behavior but no goal: it stands still"


def _angle_notes(body: BodySpec) -> Iterator[str]:
    headings = [body.state[2]] if body.state is not None else []
    headings += [goal[2] for goal in body.goal if not math.isnan(goal[2])]
    angles = [("a heading", value) for value in headings]
    angles += [("angle_range", getattr(sensor, "angle_range", 0.0)) for sensor in body.sensors]
    for name, value in angles:
        if abs(value) > FULL_TURN:
            yield f"{name} of {value:g} is more than a turn: {DEGREES}"
