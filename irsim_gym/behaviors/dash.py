"""Dash: drive straight at the goal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.geometry.angles import wrap_below
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import crossed_bounds, kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD, WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState


@kind
class Dash:
    """Drive straight at the goal, turning towards it on the way."""

    only_kernels: ClassVar[bool] = True
    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni", "omni_angular", "acker")
    reads_neighbors: ClassVar[bool] = False

    wander: bool = option(False, meaning="Draw a new random goal after each arrival.")
    loop: bool = option(False, meaning="Begin again with the first goal after the last.")
    target_roles: Literal["all", "robot", "obstacle"] = option(
        "all", meaning="Which other bodies the behaviour sees; dash looks at none."
    )
    range_low: tuple[float, float, float] = option(
        (0.0, 0.0, -np.pi), unit="m, m, rad", meaning="Lower bounds of a wandering body's goals."
    )
    range_high: tuple[float, float, float] = option(
        (10.0, 10.0, np.pi), unit="m, m, rad", meaning="Upper bounds of a wandering body's goals."
    )
    angle_tolerance: float = option(
        0.1,
        ge=0.0,
        unit="rad",
        meaning="No turn while the bearing of the goal is smaller than this.",
        consequence="Large: it passes its goal by.",
    )

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        yield from crossed_bounds(self.range_low, self.range_high)

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> None:
        """Need no memory."""

    @staticmethod
    def decide(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Write the members' commands; all members of a group have one drive."""
        KERNELS[int(model.drive[group.members[0]])](
            shard.worlds,
            group.members,
            group.params,
            model.step_time,
            model.goal_threshold,
            model.velocity_max,
            model.acceleration_limit,
            state.pose,
            state.goal,
            model.has_goal,
            state.command,
        )


@kernel
def dash_differential(
    worlds: Ints,
    members: Ints,
    params: Any,
    step_time: Floats,
    goal_threshold: Floats,
    velocity_max: Floats,
    acceleration_limit: Floats,
    pose: Floats,
    goal: Floats,
    has_goal: Flags,
    command: Floats,
) -> None:
    """Write a differential drive's command: v = v_max cos(e), a turn towards the goal at full or braking rate.

    ``e`` is the goal's bearing; behind the robot the speed is negative. With a limited angular acceleration the
    turn rate is held down to what can still be braked before the goal is ahead.
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            command[w, b, 0], command[w, b, 1], command[w, b, 2] = 0.0, 0.0, 0.0
            dx, dy = goal[w, b, 0] - pose[w, b, 0], goal[w, b, 1] - pose[w, b, 1]
            if not has_goal[b] or np.sqrt(dx * dx + dy * dy) < goal_threshold[row_of(goal_threshold, w), b]:
                continue
            fastest = velocity_max[row_of(velocity_max, w), b]
            error = wrap_below(np.arctan2(dy, dx) - pose[w, b, 2])
            command[w, b, 0] = fastest[0] * np.cos(error)
            if np.abs(error) >= params[k].angle_tolerance:
                command[w, b, 1] = turn_rate(
                    error,
                    params[k].angle_tolerance,
                    np.abs(fastest[1]),
                    acceleration_limit[row_of(acceleration_limit, w), b, 1],
                    step_time[0],
                )


@kernel
def dash_omni(
    worlds: Ints,
    members: Ints,
    params: Any,
    step_time: Floats,
    goal_threshold: Floats,
    velocity_max: Floats,
    acceleration_limit: Floats,
    pose: Floats,
    goal: Floats,
    has_goal: Flags,
    command: Floats,
) -> None:
    """Write an omnidirectional drive's command in the body frame: each component at its share of its own limit.

    With unequal limits the way is not straight. There is no slowing down.
    """
    for w in worlds:
        for b in members:
            command[w, b, 0], command[w, b, 1], command[w, b, 2] = 0.0, 0.0, 0.0
            dx, dy = goal[w, b, 0] - pose[w, b, 0], goal[w, b, 1] - pose[w, b, 1]
            if not has_goal[b] or np.sqrt(dx * dx + dy * dy) <= goal_threshold[row_of(goal_threshold, w), b]:
                continue
            fastest = velocity_max[row_of(velocity_max, w), b]
            error = wrap_below(np.arctan2(dy, dx) - pose[w, b, 2])
            command[w, b, 0], command[w, b, 1] = fastest[0] * np.cos(error), fastest[1] * np.sin(error)


@kernel
def dash_omni_world(
    worlds: Ints,
    members: Ints,
    params: Any,
    step_time: Floats,
    goal_threshold: Floats,
    velocity_max: Floats,
    acceleration_limit: Floats,
    pose: Floats,
    goal: Floats,
    has_goal: Flags,
    command: Floats,
) -> None:
    """Write an omnidirectional drive's command in the world frame, as ``dash_omni`` does at heading 0."""
    for w in worlds:
        for b in members:
            command[w, b, 0], command[w, b, 1], command[w, b, 2] = 0.0, 0.0, 0.0
            dx, dy = goal[w, b, 0] - pose[w, b, 0], goal[w, b, 1] - pose[w, b, 1]
            if not has_goal[b] or np.sqrt(dx * dx + dy * dy) <= goal_threshold[row_of(goal_threshold, w), b]:
                continue
            fastest = velocity_max[row_of(velocity_max, w), b]
            direction = np.arctan2(dy, dx)
            command[w, b, 0], command[w, b, 1] = fastest[0] * np.cos(direction), fastest[1] * np.sin(direction)


@kernel
def dash_omni_angular(
    worlds: Ints,
    members: Ints,
    params: Any,
    step_time: Floats,
    goal_threshold: Floats,
    velocity_max: Floats,
    acceleration_limit: Floats,
    pose: Floats,
    goal: Floats,
    has_goal: Flags,
    command: Floats,
) -> None:
    """Write the command of an omnidirectional drive that turns: towards the goal, and there to the goal's heading."""
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            command[w, b, 0], command[w, b, 1], command[w, b, 2] = 0.0, 0.0, 0.0
            if not has_goal[b]:
                continue
            dx, dy = goal[w, b, 0] - pose[w, b, 0], goal[w, b, 1] - pose[w, b, 1]
            fastest = velocity_max[row_of(velocity_max, w), b]
            target = goal[w, b, 2]
            if np.sqrt(dx * dx + dy * dy) > goal_threshold[row_of(goal_threshold, w), b]:
                target = np.arctan2(dy, dx)
                error = wrap_below(target - pose[w, b, 2])
                command[w, b, 0], command[w, b, 1] = fastest[0] * np.cos(error), fastest[1] * np.sin(error)
            if np.isnan(target):
                continue
            error = wrap_below(target - pose[w, b, 2])
            if np.abs(error) > params[k].angle_tolerance:
                command[w, b, 2] = turn_rate(
                    error,
                    params[k].angle_tolerance,
                    np.abs(fastest[2]),
                    acceleration_limit[row_of(acceleration_limit, w), b, 2],
                    step_time[0],
                )


@kernel
def dash_ackermann(
    worlds: Ints,
    members: Ints,
    params: Any,
    step_time: Floats,
    goal_threshold: Floats,
    velocity_max: Floats,
    acceleration_limit: Floats,
    pose: Floats,
    goal: Floats,
    has_goal: Flags,
    command: Floats,
) -> None:
    """Write a car's command: full speed, and the goal's bearing as steering angle (or as yaw rate per second).

    It never slows down or reverses, so it circles around a goal that is nearer than it can turn.
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            command[w, b, 0], command[w, b, 1], command[w, b, 2] = 0.0, 0.0, 0.0
            dx, dy = goal[w, b, 0] - pose[w, b, 0], goal[w, b, 1] - pose[w, b, 1]
            if not has_goal[b] or np.sqrt(dx * dx + dy * dy) < goal_threshold[row_of(goal_threshold, w), b]:
                continue
            fastest = velocity_max[row_of(velocity_max, w), b]
            error = wrap_below(np.arctan2(dy, dx) - pose[w, b, 2])
            command[w, b, 0] = fastest[0]
            if np.abs(error) >= params[k].angle_tolerance:
                command[w, b, 1] = min(max(error, -fastest[1]), fastest[1])


@kernel
def turn_rate(error: float, tolerance: float, fastest: float, acceleration: float, dt: float) -> float:
    """Return the turn rate towards a bearing ``error`` [rad]: full speed, or what can be braked in time [rad/s]."""
    rate = fastest
    if np.isfinite(acceleration) and acceleration > 0.0:
        braking = acceleration * dt
        reach = np.sqrt(braking * braking + 2.0 * acceleration * (np.abs(error) - tolerance)) - braking
        rate = min(fastest, reach)
    return rate if error > 0.0 else -rate


KERNELS: Mapping[int, Callable[..., None]] = MappingProxyType(
    {
        DIFFERENTIAL: dash_differential,
        OMNI_WORLD: dash_omni_world,
        OMNI_BODY: dash_omni,
        OMNI_ANGULAR: dash_omni_angular,
        ACKERMANN: dash_ackermann,
    }
)
