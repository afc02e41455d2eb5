"""Finds values that are allowed but suspicious: loading warns of most, and ``irsim-gym check`` lists all of them."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from irsim_gym.base.errors import IgnoredKeyWarning, Problem, ScenarioWarning, warn_caller
from irsim_gym.base.families import KINEMATICS
from irsim_gym.scenario.checking.validation import Report, read_numbers
from irsim_gym.scenario.entries.body_checks import speed_count
from irsim_gym.scenario.entries.shorthand import split_entries
from irsim_gym.scenario.reading.level_doubts import level_doubts
from irsim_gym.scenario.specs.spec import BodySpec, Scenario
from irsim_gym.scenario.text.source import ROLES, Place

LARGEST_ANGLE = 2.0 * math.pi + 1e-3
LONGEST_STEP = 1.0
FASTEST_TURN = 4.0 * math.pi
"""Turn rate above which a limit is taken for degrees [rad/s]."""
FAR = 2.0
"""Ranges of sensors above this multiple of the world's diagonal are noted."""
IDLE = "has a behavior but no goal: it stands still"
DEGREES = "angles are in radians; you can write pi/2"


def warn(scenario: Scenario) -> None:
    """Warn of suspicious values and of ignored keys, with one warning each."""
    _warn(ScenarioWarning, scenario.source.title, doubts(scenario))
    warn_of_keys(scenario.source.title, scenario.ignored)


def warn_of_keys(title: str, ignored: Iterable[Problem]) -> None:
    """Warn of ignored keys; the title names the file."""
    _warn(IgnoredKeyWarning, title, tuple(ignored))


def warn_of_starts(scenario: Scenario, starts: Sequence[Problem]) -> None:
    """Warn of robots that start inside an obstacle (``simulator.engine.start_checks.find_blocked_starts``)."""
    held = [replace(problem, message=f"{problem.message}: the robot is stuck there") for problem in starts]
    _warn(ScenarioWarning, scenario.source.title, held)


def _warn(category: type[ScenarioWarning], title: str, problems: Sequence[Problem]) -> None:
    """Warn of all problems found, at the line that called this package."""
    if not problems:
        return
    warn_caller(category(title, problems))


def notes(scenario: Scenario) -> tuple[Problem, ...]:
    """Return all remarks about a scenario that are not errors, in the order of its lines."""
    problems = [Problem(body.line, body.name, IDLE) for body in scenario.bodies if _is_idle(body, scenario)]
    for body in scenario.bodies:
        further = (*_goals_outside(body, scenario), *_limit_notes(body, scenario), *_range_notes(body, scenario))
        problems += [Problem(body.line, body.name, message) for message in further]
    return tuple(sorted({*_in_order([*doubts(scenario), *problems]), *scenario.ignored}))


def doubts(scenario: Scenario) -> tuple[Problem, ...]:
    """Return remarks about suspicious values, in the order of their lines."""
    problems = [*scenario.doubts, *_world_notes(scenario), *_view_notes(scenario), *_level_notes(scenario)]
    for body in scenario.bodies:
        messages = [*_angle_notes(body), *(_stride_notes(body, scenario) if body.goal else ())]
        problems += [Problem(body.line, body.name, message) for message in messages]
    return _in_order(problems)


def _in_order(problems: Iterable[Problem]) -> tuple[Problem, ...]:
    """Return remarks sorted by line; a remark on several bodies of an entry appears once."""
    seen: dict[tuple[int, str], Problem] = {}
    for note in problems:
        seen.setdefault((note.line, note.message), note)
    return tuple(sorted(seen.values()))


def _world_notes(scenario: Scenario) -> Iterator[Problem]:
    world = scenario.world
    if world.collision_check == "swept":
        return
    yield from _passing_notes(scenario)
    if world.step_time > LONGEST_STEP:
        yield scenario.problem(("world", "step_time"), f"{world.step_time:g} s is a long step: bodies may pass walls")


def _passing_notes(scenario: Scenario) -> Iterator[Problem]:
    """Yield a remark if a step can take a body past another one, or past a cell of the map, without a contact."""
    world, widths, excess = scenario.world, dict[int, float](), []
    for b, body in enumerate(scenario.bodies):
        n_speeds = 0 if body.static else speed_count(body.kinematics)
        stride = max(map(abs, (*body.vel_max[:n_speeds], *body.vel_min[:n_speeds])), default=0.0) * world.step_time
        if id(body.shape) not in widths:  # bodies of an entry share their shape
            widths[id(body.shape)] = _thickness(body.shape.outline())
        width = widths[id(body.shape)]
        if scenario.occupied is not None and b == len(scenario.bodies) - 1:
            columns, rows = scenario.occupied.shape
            width = min(world.width / columns, world.height / rows)
        if not body.unobstructed:
            excess.append((stride - width, stride, body))
    # Two pass each other in a step if both strides together exceed both widths: if any do, those of the largest excess.
    excess.sort(key=lambda row: -row[0])
    first = next((row for row in excess if row[1] > 0.0), None)
    second = next((row for row in excess if row is not first), None)
    if first is not None and second is not None and first[0] + second[0] > 0.0:
        message = f"a step of {first[1]:g} m may jump over '{second[2].name}': reduce step_time, or set collision_check"
        yield Problem(first[2].line, first[2].name, f"{message}: swept in world")


def _thickness(outline: Any) -> float:
    """Return the least width of an outline [m]: that of its thinnest disc, or across one of its sides."""
    widths = [2.0 * float(disc[2]) for disc in outline.discs]
    corners = outline.segments.reshape(-1, 2)
    for x0, y0, x1, y1 in outline.segments if outline.solid else ():
        across = ((y1 - y0) * corners[:, 0] - (x1 - x0) * corners[:, 1]) / max(math.hypot(x1 - x0, y1 - y0), 1e-12)
        widths.append(float(across.max() - across.min()))
    return min(widths, default=0.0)


def warn_of_levels(scenario: Scenario, title: str) -> None:
    """Warn of levels that begin badly; the title names their file."""
    _warn(ScenarioWarning, title, [replace(problem, line=0) for problem in _level_notes(scenario)])


def _level_notes(scenario: Scenario) -> Iterator[Problem]:
    for name, message in level_doubts(scenario):
        yield scenario.problem(("levels",), f"'{name}' {message}")


def _view_notes(scenario: Scenario) -> Iterator[Problem]:
    """Yield remarks about ``fov`` as written in the file, since that of a body is limited to a full turn."""
    root: Place = scenario.root.get("robot", ()) or scenario.root.get("obstacle", ())
    sections = scenario.source.data[root[0]] if root else scenario.source.data
    for role in ROLES:
        for entry in split_entries(role, (sections or {}).get(role), (*root, role), Report(scenario.source)):
            value = read_numbers(entry.data.get("fov"))
            for width in value if isinstance(value, list) else [value]:
                if width is not None and width > LARGEST_ANGLE:
                    yield scenario.source.problem((*entry.place, "fov"), f"fov {width:g} exceeds a turn: {DEGREES}")


def _stride_notes(body: BodySpec, scenario: Scenario) -> Iterator[str]:
    """Yield a remark if a step at full speed may lead over a goal; bodies without a drive have no speed to set."""
    if body.kinematics is None or body.static:
        return
    drive = KINEMATICS.name_of(type(body.kinematics))
    speed = body.vel_max[0] if drive in ("diff", "acker") else max(body.vel_max[:2])
    stride = speed * scenario.world.step_time
    if stride > 2.0 * body.goal_threshold:
        yield (
            f"a step of {stride:g} m may jump over a goal_threshold of {body.goal_threshold:g} m: "
            "reduce the step or enlarge the threshold"
        )


def _limit_notes(body: BodySpec, scenario: Scenario) -> Iterator[str]:
    """Yield remarks about limits of moving robots, and about goals that are drawn for them."""
    if body.static or body.role != "robot":
        return
    words = getattr(body.kinematics, "command_words", ())
    for k, (what, unit) in enumerate(words):
        most = max(abs(value) for value in (body.vel_min[k], body.vel_max[k]))
        if unit == "rad/s" and FASTEST_TURN < most < math.inf:
            yield f"a turn rate of {most:g} rad/s is more than two turns in a second: {DEGREES}"
        if unit == "rad" and math.pi / 2.0 < most < math.inf:
            yield f"a {what.split(',')[0]} of {most:g} rad is more than a right angle: {DEGREES}"
    speeds = [k for k, (_, unit) in enumerate(words) if unit == "m/s"]
    if speeds and all(body.vel_max[k] <= 0.0 for k in speeds):
        is_reverse = any(body.vel_min[k] < 0.0 for k in speeds)
        turns = any((*body.vel_min, *body.vel_max))
        yield f"vel_max is 0: it can only {'drive backwards' if is_reverse else 'turn' if turns else 'stand still'}"
    placement = scenario.placements[body.entry].kind
    if placement.gives_goal or body.wanders:
        yield from _stride_notes(body, scenario)
    least = getattr(placement, "min_goal_distance", math.inf)
    if max(least, getattr(placement, "min_way_length", 0.0)) <= body.goal_threshold and (
        placement.goal_low is None and placement.goal_high is None
    ):
        yield (
            "goals may be drawn where it starts: a min_goal_distance above the goal_threshold "
            f"({body.goal_threshold:g} m) prevents that"
        )


def _range_notes(body: BodySpec, scenario: Scenario) -> Iterator[str]:
    """Yield remarks about sensors that reach far beyond the world."""
    diagonal = math.hypot(scenario.world.width, scenario.world.height)
    for sensor in body.sensors:
        reach = getattr(sensor, "range_max", 0.0)
        if reach > FAR * diagonal:
            yield (
                f"a range_max of {reach:g} m in a world of {diagonal:.3g} m across: "
                "observations are shares of it, so all that the robot can see are small numbers"
            )


def _is_idle(body: BodySpec, scenario: Scenario) -> bool:
    """Return whether a body decides but has no goal; this is no warning, since a goal may be set by hand."""
    decides = body.behavior or body.group_behavior
    places = bool(body.goal) or scenario.placements[body.entry].kind.gives_goal
    replays = bool(getattr(body.behavior, "replays", False))
    return bool(decides) and not body.static and not places and not body.wanders and not replays


def _goals_outside(body: BodySpec, scenario: Scenario) -> Iterator[str]:
    """Yield remarks about goals outside the world; they are no warnings, since bodies may leave it as in IR-SIM."""
    world = scenario.world
    low, high = world.offset, (world.offset[0] + world.width, world.offset[1] + world.height)
    for goal in body.goal:
        if not (low[0] <= goal[0] <= high[0] and low[1] <= goal[1] <= high[1]):
            yield (
                f"the goal ({goal[0]:g}, {goal[1]:g}) is outside the world, "
                f"which extends from ({low[0]:g}, {low[1]:g}) to ({high[0]:g}, {high[1]:g})"
            )


def _angle_notes(body: BodySpec) -> Iterator[str]:
    headings = [body.state[2]] if body.state is not None else []
    headings += [goal[2] for goal in body.goal if not math.isnan(goal[2])]
    angles = [("a heading", value) for value in headings]
    angles += [("angle_range", getattr(sensor, "angle_range", 0.0)) for sensor in body.sensors]
    for name, value in angles:
        if abs(value) > LARGEST_ANGLE:
            yield f"{name} of {value:g} is more than a turn: {DEGREES}"
