"""Dash: drive straight at the goal."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.bodies.behaviors.shared.steering import braked_rate, clear_command, goal_offset
from irsim_gym.scenario.specs.wander_goals import RenewsGoals
from irsim_gym.simulator.geometry.angles import wrap_below
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD, Model
from irsim_gym.simulator.world.names import Group, Ints, Shard, State, kernel, kind, option, row_of


@kind
class Dash(RenewsGoals):
    """Drive straight at the goal, turning towards it on the way."""

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni", "omni_angular", "acker")
    reads_neighbors: ClassVar[bool] = False

    target_roles: Literal["all", "robot", "obstacle"] = option(
        "all", meaning="Which other bodies the behaviour sees; dash looks at none."
    )
    angle_tolerance: float = option(
        0.1,
        ge=0.0,
        unit="rad",
        meaning="No turn while the bearing of the goal is smaller than this.",
        consequence="Large: it passes its goal by.",
    )

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Do nothing: the behaviour needs no memory."""

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' commands; all members of a group have one drive."""
        KERNELS[int(model.drive[group.members[0]])](shard.worlds, group.members, group.params, model, state)


@kernel
def dash_differential(worlds: Ints, members: Ints, params: Any, model: Model, state: State) -> None:
    """Write a differential drive's command: v = v_max cos(e), a turn towards the goal at full or braking rate.

    ``e`` is the goal's bearing; behind the robot the speed is negative. With a limited angular acceleration the
    turn rate is held down to what can still be braked before the goal is ahead.

    Reads: model (acceleration_limit, goal_threshold, has_goal, step_time, velocity_max), state (goal, pose).
    Writes: state (command).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            clear_command(state, w, b)
            dx, dy = goal_offset(state, w, b)
            near = model.goal_threshold[row_of(model.goal_threshold, w), b]
            if not model.has_goal[b] or np.sqrt(dx * dx + dy * dy) < near:
                continue
            fastest = model.velocity_max[row_of(model.velocity_max, w), b]
            error = wrap_below(np.arctan2(dy, dx) - state.pose[w, b, 2])
            # A negative cosine drives the body backwards while it turns to a goal behind it.
            state.command[w, b, 0] = fastest[0] * np.cos(error)
            if np.abs(error) >= params[k].angle_tolerance:
                state.command[w, b, 1] = turn_rate(model, w, b, 1, error, params[k].angle_tolerance)


@kernel
def dash_omni(worlds: Ints, members: Ints, params: Any, model: Model, state: State) -> None:
    """Write an omnidirectional drive's command: each component at its share of its own limit.

    With unequal limits the way is not straight. There is no slowing down.

    Reads: model (drive, goal_threshold, has_goal, velocity_max), state (goal, pose).
    Writes: state (command).
    """
    for w in worlds:
        for b in members:
            clear_command(state, w, b)
            dx, dy = goal_offset(state, w, b)
            near = model.goal_threshold[row_of(model.goal_threshold, w), b]
            # At the threshold itself this drive stands, as in IR-SIM; those that roll still drive there.
            if not model.has_goal[b] or np.sqrt(dx * dx + dy * dy) <= near:
                continue
            fastest = model.velocity_max[row_of(model.velocity_max, w), b]
            angle = np.arctan2(dy, dx)
            if model.drive[b] == OMNI_BODY:
                angle = wrap_below(angle - state.pose[w, b, 2])
            state.command[w, b, 0], state.command[w, b, 1] = fastest[0] * np.cos(angle), fastest[1] * np.sin(angle)


@kernel
def dash_omni_angular(worlds: Ints, members: Ints, params: Any, model: Model, state: State) -> None:
    """Write the command of an omnidirectional drive that turns: towards the goal, and there to the goal's heading.

    Reads: model (acceleration_limit, goal_threshold, has_goal, step_time, velocity_max), state (goal, pose).
    Writes: state (command).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            clear_command(state, w, b)
            if not model.has_goal[b]:
                continue
            dx, dy = goal_offset(state, w, b)
            fastest = model.velocity_max[row_of(model.velocity_max, w), b]
            # Within the threshold, the body turns to the goal's own heading, NaN if the goal has none.
            target = state.goal[w, b, 2]
            if np.sqrt(dx * dx + dy * dy) > model.goal_threshold[row_of(model.goal_threshold, w), b]:
                target = np.arctan2(dy, dx)
                error = wrap_below(target - state.pose[w, b, 2])
                state.command[w, b, 0], state.command[w, b, 1] = fastest[0] * np.cos(error), fastest[1] * np.sin(error)
            if np.isnan(target):
                continue
            error = wrap_below(target - state.pose[w, b, 2])
            if np.abs(error) > params[k].angle_tolerance:
                state.command[w, b, 2] = turn_rate(model, w, b, 2, error, params[k].angle_tolerance)


@kernel
def dash_ackermann(worlds: Ints, members: Ints, params: Any, model: Model, state: State) -> None:
    """Write a car's command: full speed, and the goal's bearing as steering angle (or as yaw rate per second).

    It never slows down or reverses, so it circles around a goal that is nearer than it can turn.

    Reads: model (goal_threshold, has_goal, velocity_max), state (goal, pose).
    Writes: state (command).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            clear_command(state, w, b)
            dx, dy = goal_offset(state, w, b)
            near = model.goal_threshold[row_of(model.goal_threshold, w), b]
            if not model.has_goal[b] or np.sqrt(dx * dx + dy * dy) < near:
                continue
            fastest = model.velocity_max[row_of(model.velocity_max, w), b]
            error = wrap_below(np.arctan2(dy, dx) - state.pose[w, b, 2])
            state.command[w, b, 0] = fastest[0]
            if np.abs(error) >= params[k].angle_tolerance:
                state.command[w, b, 1] = min(max(error, -fastest[1]), fastest[1])


@kernel
def turn_rate(model: Model, w: int, b: int, turn: int, error: float, tolerance: float) -> float:
    """Return the turn rate towards a bearing ``error`` [rad]: full speed, or what can be braked in time [rad/s].

    Reads: model (acceleration_limit, step_time, velocity_max).

    Args:
        model: What the body can do.
        w: World.
        b: The body.
        turn: Which of its velocities is the turn rate.
        error: The bearing [rad].
        tolerance: Bearings up to this need no turn [rad].
    """
    # A negative limit is read as its magnitude, as in IR-SIM.
    rate = float(np.abs(model.velocity_max[row_of(model.velocity_max, w), b, turn]))
    acceleration = model.acceleration_limit[row_of(model.acceleration_limit, w), b, turn]
    rate = braked_rate(rate, acceleration, model.step_time[0], np.abs(error) - tolerance)
    return rate if error > 0.0 else -rate


KERNELS: Mapping[int, Callable[..., None]] = MappingProxyType(
    {
        DIFFERENTIAL: dash_differential,
        OMNI_WORLD: dash_omni,
        OMNI_BODY: dash_omni,
        OMNI_ANGULAR: dash_omni_angular,
        ACKERMANN: dash_ackermann,
    }
)
