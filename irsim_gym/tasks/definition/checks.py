"""Checks that a task fits its scenario, and that its terms fit each other."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np

from irsim_gym.base.errors import Problem, UnknownNameError, suggestion
from irsim_gym.base.families import ENDINGS, OBSERVATIONS, REWARDS, SENSORS
from irsim_gym.base.options import option_fields
from irsim_gym.scenario.checking.validation import Report
from irsim_gym.scenario.specs.spec import BodySpec, PlacementSpec, Scenario
from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.source import Place
from irsim_gym.simulator.world.model import NO_DRIVE
from irsim_gym.tasks.definition.audit import Terms, ending_for
from irsim_gym.tasks.definition.layers import Merged
from irsim_gym.tasks.terms.graph import HasGraph
from irsim_gym.tasks.terms.targets import FitsScenario, has_goal

NOTHING = "nothing"
"""``without_sensor``: the observation of a sensor without beams."""
OTHERWISE = "; task: {agents: NAME} lets another robot learn, and irsim_gym.load runs a file without learning"


def choose_agents(scenario: Scenario, chosen: str | Sequence[str], team: bool, merged: Merged) -> tuple[int, ...]:
    """Return the bodies that learn; empty after reporting problems.

    Args:
        scenario: The scenario.
        chosen: A robot's name, several names, ``all``, or empty.
        team: Whether empty means all robots instead of the first one.
        merged: Collects the problems.
    """
    robots = scenario.robots
    if not robots:
        problem = Problem(0, "robot", "there is no robot that can learn")
        merged.outside.append((scenario.source.title, problem))
        return ()
    if scenario.world.step_mode == "external":
        message = "the bodies do not move by themselves, so no robot can learn; irsim_gym.load runs such a world"
        merged.outside.append((scenario.source.title, scenario.problem(("world", "step_mode"), message)))
        return ()
    if not chosen:
        return robots if team else robots[:1]
    if chosen == "all":
        return robots
    names = [chosen] if isinstance(chosen, str) else list(chosen)
    by_name = {scenario.bodies[b].name: b for b in robots}
    others = {body.name for body in scenario.bodies} - set(by_name)
    for i, name in enumerate(names):
        place: Place = ("agents",) if isinstance(chosen, str) else ("agents", i)
        if name in others:
            merged.report.add(place, f"'{name}' is an obstacle; only robots can learn")
        elif name not in by_name:
            merged.report.add(place, _unknown_learner(scenario, name, list(by_name)))
        elif name in names[:i]:
            merged.report.add(place, f"'{name}' is named twice")
    return tuple(by_name[name] for name in names) if set(names) <= set(by_name) else ()


def _unknown_learner(scenario: Scenario, name: str, names: Sequence[str]) -> str:
    """Return the message about a learner's name that no robot has."""
    members = [scenario.bodies[b].name for b in scenario.robots if scenario.bodies[b].group_name == name]
    if members:
        return f"'{name}' is a group: name its robots, {_first_names(members)}"
    return f"no robot named '{name}'{suggestion(name, names)}; the robots: {_first_names(names)}"


def _first_names(names: Sequence[str], most: int = 10) -> str:
    """Return the first names, and the number of others, as text."""
    others = f" and {len(names) - most} others" if len(names) > most else ""
    return ", ".join(names[:most]) + others


def check_fit(
    scenario: Scenario, agents: Sequence[int], task: str, terms: Terms, merged: Merged
) -> list[tuple[Place, Any]]:
    """Report what the learners lack, and return the observations, with substitutes for missing sensors."""
    bodies = [scenario.bodies[b] for b in agents]
    problems = [
        Problem(body.line, body.name, message)
        for b, body in zip(agents, bodies, strict=True)
        for message in _body_problems(body, scenario.placements[body.entry], b)
    ]
    for place, term in chain(*terms.values()):
        if isinstance(term, FitsScenario) and (lack := term.misfit(scenario)) is not None:
            merged.report.add(place, lack)
    needing = [term for item in terms.values() for _, term in item if term.needs_goal]
    if needing:
        users = ", ".join(f"'{_term_name(term)}'" for term in needing)
        message = (
            f"has no goal, and the task '{task}' needs one (for {users}): add a goal, or take a task without, "
            "such as {name: blank, observations: [velocity]}"
        )
        goalless = [body for b, body in zip(agents, bodies, strict=True) if not has_goal(scenario, b)]
        problems += [Problem(body.line, body.name, message) for body in goalless]
    for i, problem in enumerate(problems):
        shown = problem if i else replace(problem, message=problem.message + OTHERWISE)
        merged.outside.append((scenario.source.title, shown))
    return _with_substitutes(terms["observations"], bodies, merged.report)


def _with_substitutes(
    observations: Sequence[tuple[Place, Any]], bodies: Sequence[BodySpec], report: Report
) -> list[tuple[Place, Any]]:
    """Return a list of observations, with substitutes for missing sensors."""
    kinds = [type(item) for _, item in observations]
    fitting = []
    for place, item in observations:
        for fit in _substitutes(place, item, bodies, report) if "scan" in (item.needs or ()) else [item]:
            if fit is item or type(fit) not in kinds:
                fitting.append((place, fit))
                kinds.append(type(fit))
    return fitting


def check_action(scenario: Scenario, agents: Sequence[int], action: object, report: Report) -> None:
    """Report choices for a component that the learners' drive does not have."""
    drives = [scenario.bodies[b].kinematics for b in agents]
    small = [drive for drive in drives if drive is not None and len(drive.command_names) < 3]
    if small and getattr(action, "lateral", 1) > 1:
        names = ", ".join(small[0].command_names)
        message = f"must be 1 for a drive with {len(small[0].command_names)} components ({names})"
        report.add(("action", "lateral"), message)


def check_shield(scenario: Scenario, agents: Sequence[int], merged: Merged) -> None:
    """Report learners that no shield can stop in time."""
    for body in (scenario.bodies[b] for b in agents):
        if not any(sensor.reading == "ranges" for sensor in body.sensors):
            problem = "has a shield and no range sensor; add sensors: [{name: lidar2d}] to it"
        elif any(low > 0.0 for low in body.vel_min) or any(high < 0.0 for high in body.vel_max):
            problem = f"has a shield and cannot stand: vel_min is {show(body.vel_min)}, vel_max {show(body.vel_max)}"
        elif not hasattr(type(body.kinematics), "drive"):
            problem = "has a shield, which does not know how its drive moves"
        else:
            continue
        merged.outside.append((scenario.source.title, Problem(body.line, body.name, problem)))


def check_prediction(scenario: Scenario, agents: Sequence[int], terms: Terms, report: Report) -> None:
    """Report observations and drives that cannot be predicted."""
    for place, item in terms["observations"]:
        needs = ("?",) if item.needs is None else item.needs
        if len(agents) > 1 and "bodies" in needs:
            message = "cannot be predicted in a team, whose robots all have commands under way"
        elif isinstance(item, HasGraph) or set(needs) <= {"odometry"}:
            continue
        else:
            message = "cannot be predicted"
        report.add(place, f"'{_term_name(item)}' {message}: leave out either it or 'predict'")
    for body in (scenario.bodies[b] for b in agents):
        if getattr(body.kinematics, "drive", NO_DRIVE) == NO_DRIVE:
            report.add(("predict",), f"must be left out: where its drive takes '{body.name}' is not known")
            break


def _body_problems(body: BodySpec, placement: PlacementSpec, b: int) -> list[str]:
    if placement.number_range is not None and b - placement.members[0] >= placement.number_range[0]:
        return ["cannot learn: number_range may leave it out"]
    if body.static or body.kinematics is None:
        return ["cannot learn: it never moves"]
    if not np.isfinite([*body.vel_min, *body.vel_max]).all():
        return ["cannot learn: its velocity limits must be finite"]
    if not np.any([*body.vel_min, *body.vel_max]):
        return ["cannot learn: its velocity limits vel_min and vel_max are all 0"]
    return []


def _term_name(term: object) -> str:
    for family in (OBSERVATIONS, REWARDS, ENDINGS):
        try:
            return family.name_of(type(term))
        except UnknownNameError:
            continue
    return type(term).__name__


def _substitutes(place: Place, item: object, bodies: Sequence[BodySpec], report: Report) -> list[object]:
    """Return an observation that needs a range sensor, or its substitutes if there is no sensor."""
    option = getattr(item, "without_sensor", "")  # kinds of plugins may lack this option
    names = [option] if isinstance(option, str) else option
    substitutes = [name for name in names if name]
    scanners = [[sensor for sensor in body.sensors if sensor.reading == "ranges"] for body in bodies]
    without = [body.name for body, lidar in zip(bodies, scanners, strict=True) if not lidar]
    if substitutes == [NOTHING] and without:
        if len(without) < len(bodies):
            rule = f"'{NOTHING}' needs learners that all have a range sensor, or none of which has one"
            report.add((*place, "without_sensor"), f"{rule}: '{without[0]}' has none")
        return [item]
    unknown = [name for name in substitutes if name not in OBSERVATIONS and substitutes != [NOTHING]]
    for name in unknown:
        message = f"no observation named '{name}'{suggestion(name, OBSERVATIONS.names())}"
        report.add((*place, "without_sensor"), message)
    if unknown:
        return [item]
    if not without:
        first = scanners[0][0]
        for body, (lidar, *_) in zip(bodies, scanners, strict=True):
            if (type(lidar), lidar.group_key()) != (type(first), first.group_key()):
                both = f"{bodies[0].name} has {_described(first)}, {body.name} has {_described(lidar)}"
                rule = "learners of one task need range sensors of one kind with the same beams, all noisy or none"
                report.add(place, f"{rule}: {both}; task: {{agents: [NAME, ...]}} selects the learners")
                break
        return [item]
    if not substitutes:
        report.add(
            place,
            f"'{without[0]}' has no range sensor: add one, or a substitute such as 'without_sensor: nearest_bodies'",
        )
        return [item]
    blind = [name for name in substitutes if "scan" in (OBSERVATIONS.entry(name).kind().needs or ())]
    for name in blind:
        report.add((*place, "without_sensor"), f"'{name}' needs a range sensor itself")
    given = {key: getattr(item, key) for key in option_fields(type(item))} | item.told if hasattr(item, "told") else {}
    kinds = [OBSERVATIONS.entry(name).kind for name in substitutes]
    return [item] if blind else [kind(**{k: given[k] for k in given if k in option_fields(kind)}) for kind in kinds]


def _described(sensor: object) -> str:
    """Return the properties that the learners' range sensors must share, as text."""
    name = SENSORS.name_of(type(sensor))
    keys = ("number", "angle_range", "noise", "has_velocity")
    shared = [f"{key}: {show(getattr(sensor, key))}" for key in keys if hasattr(sensor, key)]
    return f"{{{', '.join([f'name: {name}', *shared])}}}"


def check_terms(terms: Terms, merged: Merged) -> None:
    """Report missing terms.

    Args:
        terms: The terms by family, with their places.
        merged: Collects the problems.
    """
    report = merged.report
    if not terms["observations"]:
        place = merged.own_place(("observations",), ("name",))
        report.add(place, "there is no observation: a task needs at least one in its list 'observations'")
    outcomes = {ending.outcome for _, ending in terms["endings"]}
    for place, reward in terms["rewards"]:
        if reward.needs_ending and reward.outcome not in outcomes:
            report.add(place, f"never applies: it needs the ending '{ending_for(reward.outcome)}'")
