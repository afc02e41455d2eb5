"""Groups of the disturbances of a scenario, and the views of the state that they act on."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from irsim_gym.base import rng
from irsim_gym.base.arraytypes import Ints
from irsim_gym.base.errors import Problem, ScenarioError
from irsim_gym.base.families import DISTURBANCES
from irsim_gym.base.options import drawn_ends
from irsim_gym.scenario.specs.spec import BodySpec, Scenario
from irsim_gym.simulator.engine.own_scans import RANGES, own_scan
from irsim_gym.simulator.step.disturbances import Belief, Disturbances
from irsim_gym.simulator.step.parts import Parts
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.group import Group
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.own_scan import OwnScan
from irsim_gym.simulator.world.state import State

Member = tuple[int, Any]
NEEDS_SCAN = "changes scans, but the robot has no range sensor; add sensors: [{name: lidar2d}] to it"
NEEDS_DRIVE = "changes how the robot drives, but it cannot move; add kinematics"
BELIEVED = ("motion", "belief")
"""What makes the pose that a robot believes in another one than the true one."""


def disturb(scenario: Scenario, agents: tuple[int, ...], model: Model, state: State, parts: Parts) -> Disturbances:
    """Return the disturbances of a scenario, and write those of commands and motions into the turns.

    Args:
        scenario: The scenario; its robots have disturbances of their own, its agents also those of all learners.
        agents: The learners.
        model: The constants.
        state: The state of the worlds, which views of it share.
        parts: The groups of the scenario, and the turns of a step.

    Raises:
        ScenarioError: A disturbance does not fit its robot.
    """
    given = [(b, one) for b in scenario.robots for one in _of(scenario, agents, b)]
    if not given:
        return Disturbances()
    _check(scenario, given, model)
    names = [entry.kind for entry in DISTURBANCES]
    kinds = sorted({type(one) for _, one in given}, key=names.index)
    found = Disturbances()
    by_kind = [(kind, [member for member in given if type(member[1]) is kind]) for kind in kinds]
    for turn in parts.turns:
        turn.commands, turn.motions = (
            [
                _group(kind, chosen, model)
                for kind, members in by_kind
                if kind.acts_on == what and (chosen := [one for one in members if one[0] in turn.movers])
            ]
            for what in ("command", "motion")
        )
        turn.asked = replace(state, command=np.zeros_like(state.command)) if turn.commands else None
        turn.moved = replace(state, velocity=np.zeros_like(state.velocity)) if turn.motions else None
        found.groups += [*turn.commands, *turn.motions]
    for kind, members in by_kind:
        if kind.acts_on == "scan":
            found.scans += [
                _scan_group(kind, members, sensor, model) for sensor in parts.sensors if _seen(members, sensor)
            ]
    found.sights = [_group(kind, members, model) for kind, members in by_kind if kind.acts_on == "sight"]
    if found.sights:
        found.seeing = replace(state, pose=state.pose.copy(), direction=state.direction.copy())
    for group in found.sights:
        group.arrays["offset"] = np.array([_offset(scenario.bodies[b]) for b in group.members])
    believers = np.unique([b for b, one in given if one.acts_on in BELIEVED]).astype(np.int64)
    if len(believers) and parts.turns:
        errors = [_group(kind, members, model, state) for kind, members in by_kind if kind.acts_on == "belief"]
        found.belief = _belief(believers, errors, parts.kinematics, state)
        found.groups += errors
    found.groups += [*found.sights, *found.scans]
    return found


def _of(scenario: Scenario, agents: tuple[int, ...], b: int) -> tuple[Any, ...]:
    """Return the disturbances of a robot."""
    return (*scenario.bodies[b].disturbances, *(scenario.disturbances if b in agents else ()))


def _offset(body: BodySpec) -> tuple[float, float, float]:
    """Return the mount pose of a robot's first range sensor."""
    return next(getattr(one, "offset", (0.0, 0.0, 0.0)) for one in body.sensors if one.reading == RANGES)


def _check(scenario: Scenario, given: Sequence[Member], model: Model) -> None:
    problems = []
    for b, one in given:
        body = scenario.bodies[b]
        has_scan = any(sensor.reading == RANGES and hasattr(sensor, "angles") for sensor in body.sensors)
        looks = one.acts_on in ("sight", "scan")
        is_lame = not looks and not model.movable[b]
        if is_lame or (looks and not has_scan):
            why = f"'{DISTURBANCES.name_of(type(one))}' {NEEDS_DRIVE if is_lame else NEEDS_SCAN}"
            problems.append(Problem(body.line, f"{body.name}.disturbances", why))
    if problems:
        raise ScenarioError(scenario.file or scenario.name, problems)


def _group(kind: type[Any], members: Sequence[Member], model: Model, state: State | None = None) -> Group:
    group = Group(kind, [one for _, one in members], np.array([b for b, _ in members], np.int64))
    if state is not None:
        group.arrays["pose"] = state.pose
    return _prepared(group, model)


def _seen(members: Sequence[Member], sensor: Group) -> bool:
    has_scan = sensor.kind.reading == RANGES and hasattr(sensor.kind, "angles")
    return has_scan and any(b in sensor.members for b, _ in members)


def _scan_group(kind: type[Any], members: Sequence[Member], sensor: Group, model: Model) -> Group:
    """Return the members of a kind whose scans a group of sensors writes, each once for each of its sensors."""
    rows = [(b, one, k) for b, one in members for k in np.flatnonzero(sensor.members == b).tolist()]
    scan: OwnScan = own_scan(sensor, np.array([k for _, _, k in rows], np.int64))
    group = Group(kind, [one for _, one, _ in rows], np.array([b for b, _, _ in rows], np.int64), scan=scan)
    return _prepared(group, model)


def _prepared(group: Group, model: Model) -> Group:
    """Return a group with what its levels draw."""
    ends = np.array([list(drawn_ends(one).values()) for one in group.options], np.float64).reshape(
        len(group.members), -1, 2
    )
    shape = len(model.present), len(group.members)
    name = DISTURBANCES.name_of(group.kind)
    numbers = [int((group.members[:k] == b).sum()) for k, b in enumerate(group.members)]
    keys = [rng.stream_base(name, f"{b} {i}") for b, i in zip(group.members, numbers, strict=True)]
    group.tables = Disturbed(
        members=group.members,
        low=np.ascontiguousarray(ends[:, :, 0]),
        high=np.ascontiguousarray(ends[:, :, 1]),
        keys=np.array(keys, np.uint64),
        values=np.zeros((*shape, ends.shape[1])),
        random=np.zeros(shape, np.uint64),
        count=np.zeros(shape, np.int64),
    )
    if hasattr(group.kind, "prepare"):
        group.kind.prepare(group, model, 1)
    return group


def _belief(believers: Ints, errors: list[Group], drives: Sequence[Group], state: State) -> Belief:
    """Return what robots believe: their odometry knows the commands that drives execute, and no noise of motion."""
    own = ("pose", "direction", "steering", "twist", "goal_distance", "random")
    told = replace(state, **{name: getattr(state, name).copy() for name in own})
    chosen = [(group, np.flatnonzero(np.isin(group.members, believers))) for group in drives]
    rolling = [group.select(members) for group, members in chosen if len(members)]
    # Tables of a drive with noise are what draws it.
    quiet = [replace(one, tables=None) if _is_noisy(one) else one for one in rolling]
    others = np.setdiff1d(np.arange(state.pose.shape[1]), believers).astype(np.int64)
    return Belief(told, quiet, errors, others, believers)


def _is_noisy(group: Group) -> bool:
    return any(getattr(options, "noise", False) for options in group.options)
