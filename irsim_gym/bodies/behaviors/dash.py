"""Dash: drive straight at the goal."""

from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.bodies.behaviors.shared.steering import braked_rate, clear_command, goal_offset
from irsim_gym.scenario.specs.wander_goals import RenewsGoals
from irsim_gym.simulator.geometry.angles import wrap_below
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_WORLD, Model
from irsim_gym.simulator.world.names import Group, Ints, Shard, State, kernel, kind, option, row_of


@kind
class Dash(RenewsGoals):
    """Drive straight at the goal, turning towards it on the way."""

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni", "omni_angular", "acker")
    reads_neighbors: ClassVar[bool] = False

    target_roles: Literal["all", "robot", "obstacle"] = option("all", meaning="No effect: dash looks at nobody.")
    angle_tolerance: float = option(
        0.1, ge=0.0, unit="rad", meaning="No turn while the goal's bearing is less.", consequence="Large: it misses."
    )

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Do nothing: the behaviour needs no memory."""

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' commands."""
        dash_all(shard.worlds, group.members, group.params, model, state)


@kernel
def dash_all(worlds: Ints, members: Ints, params: Any, model: Model, state: State) -> None:
    """Write the members' commands.

    A differential drive goes at v = v_max cos(e) with the goal's bearing e, so that behind the robot the speed is
    negative, and turns at full rate, or at one that can still be braked before the goal is ahead. A car goes at full
    speed with the bearing as steering angle (or as yaw rate per second); it never slows down or reverses, so it circles
    around a goal that is nearer than it can turn. An omnidirectional drive has each component at its share of its own
    limit, so that with unequal limits the way is not straight; one that turns does so towards the goal, and there to
    the goal's heading.

    Reads: model (acceleration_limit, drive, goal_threshold, has_goal, step_time, velocity_max), state (goal, pose).
    Writes: state (command).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b, tolerance = members[k], params[k].angle_tolerance
            drive, command = model.drive[b], state.command[w, b]
            clear_command(state, w, b)
            if not model.has_goal[b]:
                continue
            dx, dy = goal_offset(state, w, b)
            distance, near = np.sqrt(dx * dx + dy * dy), model.goal_threshold[row_of(model.goal_threshold, w), b]
            # At the threshold itself those that roll still drive, and the others stand, as in IR-SIM.
            is_there = distance < near if drive in (DIFFERENTIAL, ACKERMANN) else distance <= near
            if is_there and drive != OMNI_ANGULAR:
                continue
            # The goal's own heading is NaN if it has none, and then no turn compares as too large.
            target = state.goal[w, b, 2] if is_there else np.arctan2(dy, dx)
            error = target if drive == OMNI_WORLD else wrap_below(target - state.pose[w, b, 2])
            fastest, turns = model.velocity_max[row_of(model.velocity_max, w), b], np.abs(error) >= tolerance
            if drive == ACKERMANN:
                command[0], command[1] = fastest[0], min(max(error, -fastest[1]), fastest[1]) if turns else 0.0
            elif drive == DIFFERENTIAL:
                rate = turn_rate(model, w, b, 1, error, tolerance) if turns else 0.0
                command[0], command[1] = fastest[0] * np.cos(error), rate
            elif not is_there:
                command[0], command[1] = fastest[0] * np.cos(error), fastest[1] * np.sin(error)
            if drive == OMNI_ANGULAR and np.abs(error) > tolerance:
                command[2] = turn_rate(model, w, b, 2, error, tolerance)


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
