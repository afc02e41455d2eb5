"""Predicts the motion of a command: one step, and then a stop as soon as the body's limits allow."""

from typing import NamedTuple

import numpy as np

from irsim_gym.simulator.paths.clearance import Obstacles, way_is_free
from irsim_gym.simulator.world.names import ACKERMANN, DIFFERENTIAL, OMNI_WORLD, Floats, Model, State, kernel, row_of

MOST_STEPS = 100
"""Number of steps up to which a stop is predicted."""

Command = tuple[float, float, float]
"""The numbers of a command, as the drive has them [m/s, rad/s or rad]; unused ones are 0."""


class Moving(NamedTuple):
    """The motion and limits of a body.

    Attributes:
        drive: Its drive, see ``simulator.world.model``.
        by_rate: Whether the second number of an Ackermann drive's command is a turn rate instead of a steering angle.
        wheelbase: Axle distance [m].
        step: Duration of a step [s].
        pose: x, y, heading [m, m, rad], shape ``(3,)``.
        steering: Steering angle [rad].
        velocity: What it executes, in the coordinates of its command [m/s or rad/s], shape ``(3,)``, as all that
            follow.
        low: Lower limits.
        high: Upper limits.
        change: Largest accelerations [m/s2 or rad/s2].
    """

    drive: int
    by_rate: bool
    wheelbase: float
    step: float
    pose: Floats
    steering: float
    velocity: Floats
    low: Floats
    high: Floats
    change: Floats


@kernel
def moving_of(model: Model, state: State, w: int, b: int, by_rate: bool) -> Moving:
    """Return what body b of world w does and can do.

    Reads: model (acceleration_limit, drive, step_time, velocity_max, velocity_min, wheelbase), state (pose, steering,
        twist, velocity).
    """
    # A plugin's drive gets its command like an omnidirectional one, but `velocity` is in coordinates of its own.
    velocity = state.twist[w, b] if model.drive[b] == OMNI_WORLD else state.velocity[w, b]
    return Moving(
        model.drive[b], by_rate, model.wheelbase[b], model.step_time[0], state.pose[w, b], state.steering[w, b],
        velocity, model.velocity_min[row_of(model.velocity_min, w), b],
        model.velocity_max[row_of(model.velocity_max, w), b],
        model.acceleration_limit[row_of(model.acceleration_limit, w), b],
    )  # fmt: skip


@kernel
def window_of(moving: Moving, axis: int, now: float) -> tuple[float, float]:
    """Return the least and the greatest value of a number of the command that a step executes as it is asked for.

    That is the dynamic window: [max(v_min, v - a t), min(v_max, v + a t)] with the step's duration t.

    Args:
        moving: What the body can do.
        axis: Which number of the command.
        now: What is executed now.
    """
    change = moving.change[axis] * moving.step
    most = min(moving.high[axis], now + change)
    # A body that is faster than its limits allow cannot reach them in a step: one value is left.
    return min(max(moving.low[axis], now - change), most), most


@kernel
def executed(moving: Moving, axis: int, asked: float, now: float) -> float:
    """Return what becomes of one number of a command, from what is executed now, as ``simulator.step.command_limits``
    does.
    """
    least, most = window_of(moving, axis, now)
    return float(min(max(asked, least), most))


@kernel
def can_stop(obstacles: Obstacles, radius: float, room: float, moving: Moving, command: Command) -> bool:
    """Return whether a body touches nothing in a step with a command and while it brakes to a stop.

    A body that turns as it drives keeps its curvature as it brakes.

    Reads: obstacles (blocks, cells, model, state, w).

    Args:
        obstacles: What is in the way.
        radius: Radius of the body [m].
        room: So far the body may go in any direction [m].
        moving: What it does and can do.
        command: What it is asked to do.
    """
    x, y, heading, steering = moving.pose[0], moving.pose[1], moving.pose[2], moving.steering
    one, two, three = moving.velocity[0], moving.velocity[1], moving.velocity[2]
    first, second, third = command
    turns, from_x, from_y = moving.drive == DIFFERENTIAL or moving.by_rate, x, y
    for _ in range(MOST_STEPS):
        one, two = executed(moving, 0, first, one), executed(moving, 1, second, two)
        three = executed(moving, 2, third, three)
        next_x, next_y, heading, steering = roll(moving, x, y, heading, steering, one, two, three)
        away_x, away_y = next_x - from_x, next_y - from_y
        # Within `room` of the start nothing can be touched, so only what goes farther is tested.
        if away_x * away_x + away_y * away_y >= room * room and not way_is_free(
            obstacles, radius, (x, y), (next_x, next_y)
        ):
            return False
        x, y = next_x, next_y
        # The second number of those that roll is a turn rate or a steering angle, which moves no body at rest.
        if one == 0.0 and (two == 0.0 or moving.drive in (DIFFERENTIAL, ACKERMANN)):
            return True
        # From the second step on it brakes. A commanded turn rate falls in proportion to the speed.
        first, third = 0.0, 0.0
        if turns:
            second = two / one * executed(moving, 0, 0.0, one) if one != 0.0 else two
        elif moving.drive != ACKERMANN:
            second = 0.0
    return True


@kernel
def roll(
    moving: Moving, x: float, y: float, heading: float, steering: float, one: float, two: float, three: float
) -> tuple[float, float, float, float]:
    """Return x, y, heading and steering angle [m, m, rad, rad] after a step with executed velocities, without noise.

    As the drives of ``kinematics`` move.
    """
    step, cosine, sine = moving.step, np.cos(heading), np.sin(heading)
    if moving.drive == DIFFERENTIAL:
        return x + one * cosine * step, y + one * sine * step, heading + two * step, steering
    if moving.drive == ACKERMANN:
        # This step rolls at the angle of the previous one; after it, the wheels stand at `two`.
        rate = two if moving.by_rate else one * np.tan(steering) / moving.wheelbase
        turn = rate * step if one != 0.0 or not moving.by_rate else 0.0
        return x + one * cosine * step, y + one * sine * step, heading + turn, steering if moving.by_rate else two
    if moving.drive == OMNI_WORLD:
        return x + one * step, y + two * step, heading, steering
    along, across = cosine * one - sine * two, sine * one + cosine * two
    return x + along * step, y + across * step, heading + three * step, steering
