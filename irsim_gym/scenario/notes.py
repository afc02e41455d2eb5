"""Values that are allowed but seldom meant: ``irsim-gym check`` mentions them."""

from __future__ import annotations

import math
from collections.abc import Iterator

from irsim_gym.errors import Problem
from irsim_gym.families import KINEMATICS
from irsim_gym.scenario.spec import BodySpec, Scenario

FULL_TURN = 2.0 * math.pi + 1e-3
LONGEST_STEP = 1.0
DEGREES = "angles are radians; pi/2 may be written as it is"


def notes(scenario: Scenario) -> tuple[Problem, ...]:
    """Return what is worth a second look in a scenario, in the order of its lines; nothing of it is an error."""
    found = [*_world_notes(scenario)]
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
    angles += [("fov", body.fov or 0.0)]
    angles += [("angle_range", getattr(sensor, "angle_range", 0.0)) for sensor in body.sensors]
    for name, value in angles:
        if abs(value) > FULL_TURN:
            yield f"{name} of {value:g} is more than a turn: {DEGREES}"
