"""Groups of the disturbances of a scenario, and the views of the state that they act on."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from irsim_gym.base import rng
from irsim_gym.base.errors import Problem, ScenarioError
from irsim_gym.base.families import DISTURBANCES
from irsim_gym.base.options import drawn_ends
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.engine.own_scans import RANGES, own_scan
from irsim_gym.simulator.step.disturbances import OWN, Belief, Disturbances
from irsim_gym.simulator.step.parts import Parts
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.names import Group, Model, OwnScan, State

Member = tuple[int, Any]
NEEDS_SCAN = "changes scans, but the robot has no range sensor; add sensors: [{name: lidar2d}] to it"
NEEDS_CIRCLE = "changes a radius, but the robot has none; give it shape: {name: circle, radius: 0.2}"
NEEDS_DRIVE = "changes how the robot drives, but it cannot move; add kinematics"
BELIEVED = ("motion", "belief")
"""What makes the pose that a robot believes in another one than the true one."""
LOOKS = ("mount", "scan")
"""What belongs to range sensors."""


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
    given = [(b, item) for b in scenario.robots for item in scenario.bodies[b].disturbances]
    given += [(b, item) for b in agents for item in scenario.disturbances]
    if not given:
        return Disturbances()
    _check(scenario, given, model)
    found, kinds = Disturbances(), [entry.kind for entry in DISTURBANCES]
    by_kind = [(kind, members) for kind in kinds if (members := [item for item in given if type(item[1]) is kind])]
    for turn in parts.turns:
        turn.commands, turn.motions = (
            [
                _group(kind, chosen, model)
                for kind, members in by_kind
                if kind.acts_on == what and (chosen := [item for item in members if item[0] in turn.movers])
            ]
            for what in ("command", "motion")
        )
        turn.asked = replace(state, command=np.zeros_like(state.command)) if turn.commands else None
        turn.moved = replace(state, velocity=np.zeros_like(state.velocity)) if turn.motions else None
        found.groups += [*turn.commands, *turn.motions]
    looks = [(kind, members, sensor) for kind, members in by_kind if kind.acts_on in LOOKS for sensor in parts.sensors]
    scans = [_scan_group(*item, model) for item in looks if _seen(*item[1:])]
    found.mounts, found.scans = ([group for group in scans if group.kind.acts_on == what] for what in LOOKS)
    found.groups += scans
    found.outlines = [_group(*item, model) for item in by_kind if item[0].acts_on == "outline"]
    if found.outlines:
        resized = np.isin(np.arange(len(model.role)), np.concatenate([group.members for group in found.outlines]))
        found.known, found.reach = replace(model, reach=model.reach.copy()), np.where(resized, model.reach[0], np.nan)
    believers = [b for b, item in given if item.acts_on in BELIEVED]
    if believers and parts.turns:
        errors = [_group(*item, model) for item in by_kind if item[0].acts_on == "belief"]
        found.belief = _belief(believers, errors, parts.kinematics, state)
        found.groups += errors
    return found


def _belief(believers: list[int], errors: list[Group], drives: Sequence[Group], state: State) -> Belief:
    """Return what robots believe: their odometry knows the velocities that drives execute, and no noise of motion."""
    for group in errors:
        group.arrays["pose"] = state.pose
    told = replace(state, **{name: getattr(state, name).copy() for name in OWN})
    rolling = [drive.select(np.flatnonzero(np.isin(drive.members, believers))) for drive in drives]
    # Tables of a drive with noise are what draws it. Memories are those of the truth: belief has its own.
    quiet = [replace(drive, tables=None) if _is_noisy(drive) else drive for drive in rolling if len(drive.members)]
    for drive in quiet:
        drive.arrays = {name: array.copy() for name, array in drive.arrays.items()}
    return Belief(told, quiet, errors, np.setdiff1d(np.arange(state.pose.shape[1]), believers))


def _is_noisy(drive: Group) -> bool:
    return any(getattr(options, "noise", False) for options in drive.options)


def _check(scenario: Scenario, members: Sequence[Member], model: Model) -> None:
    problems = []
    for b, item in members:
        body = scenario.bodies[b]
        fits, needs = bool(model.movable[b]), NEEDS_DRIVE
        if item.acts_on in LOOKS:
            fits, needs = any(map(_has_ranges, body.sensors)), NEEDS_SCAN
        elif item.acts_on == "outline":
            is_disc = model.disc_count[0, b] == 1 and model.segment_count[0, b] == 0
            fits, needs = is_disc and not body.shape.is_random, NEEDS_CIRCLE
        if not fits:
            why = f"'{DISTURBANCES.name_of(type(item))}' {needs}"
            problems.append(Problem(body.line, f"{body.name}.disturbances", why))
    if problems:
        raise ScenarioError(scenario.file or scenario.name, problems)


def _group(kind: type[Any], members: Sequence[Member], model: Model) -> Group:
    return _prepared(Group(kind, [item for _, item in members], np.array([b for b, _ in members], np.int64)), model)


def _has_ranges(sensor: Any) -> bool:
    """Return whether a sensor, or a kind of sensors, has beams with ranges."""
    return sensor.reading == RANGES and hasattr(sensor, "angles")


def _seen(members: Sequence[Member], sensor: Group) -> bool:
    return _has_ranges(sensor.kind) and any(b in sensor.members for b, _ in members)


def _scan_group(kind: type[Any], members: Sequence[Member], sensor: Group, model: Model) -> Group:
    """Return the members of a kind whose scans a group of sensors writes, each once for each of its sensors."""
    rows = [(b, item, k) for b, item in members for k in np.flatnonzero(sensor.members == b).tolist()]
    scan: OwnScan = own_scan(sensor, np.array([k for _, _, k in rows], np.int64))
    group = Group(kind, [one for _, one, _ in rows], np.array([b for b, _, _ in rows], np.int64), scan=scan)
    if hasattr(sensor.tables, "offset"):
        group.arrays["mounts"] = sensor.tables.offset
    return _prepared(group, model)


def _prepared(group: Group, model: Model) -> Group:
    """Return a group with what its levels draw."""
    shape, name = (len(model.present), len(group.members)), DISTURBANCES.name_of(group.kind)
    ends = np.array([list(drawn_ends(item).values()) for item in group.options], np.float64).reshape(shape[1], -1, 2)
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
