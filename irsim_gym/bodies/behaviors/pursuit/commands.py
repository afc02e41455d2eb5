"""The commands of each drive towards a point ahead."""

import numpy as np

from irsim_gym.bodies.behaviors.pursuit.formulas import arc_curvature, regulated_speed
from irsim_gym.bodies.behaviors.pursuit.motion import Command, Moving, executed
from irsim_gym.bodies.behaviors.shared.steering import braked_rate
from irsim_gym.simulator.geometry.angles import wrap_below
from irsim_gym.simulator.world.names import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_WORLD, Point, Record, kernel

STEEPEST = 1.5
"""Steering angles are taken to be smaller than this [rad]; near a quarter turn, the tangent has no bound."""


@kernel
def command_to(options: Record, moving: Moving, target: Point, room: float, remaining: float, share: float) -> Command:
    """Return the command that brings a body to a point ahead.

    Args:
        options: Those of ``Pursuit``.
        moving: The body.
        target: The point [m].
        room: Distance of the body's surface from the nearest obstacle [m].
        remaining: What remains of the way [m].
        share: Part of the regulated speed at which it drives.
    """
    dx, dy = target[0] - moving.pose[0], target[1] - moving.pose[1]
    cosine, sine = np.cos(moving.pose[2]), np.sin(moving.pose[2])
    ahead, aside = cosine * dx + sine * dy, cosine * dy - sine * dx
    if moving.drive == DIFFERENTIAL:
        return differential_command(options, moving, ahead, aside, room, remaining, share)
    if moving.drive == ACKERMANN:
        return ackermann_command(options, moving, ahead, aside, room, remaining, share)
    # OMNI_WORLD is commanded in the world frame, all others in the body frame.
    if moving.drive != OMNI_WORLD:
        dx, dy = ahead, aside
    distance = np.sqrt(dx * dx + dy * dy)
    if distance == 0.0:
        return 0.0, 0.0, 0.0
    across, up = dx / distance, dy / distance
    fastest = min(axis_speed(moving, 0, across), axis_speed(moving, 1, up))
    speed = share * regulated_speed(options, min(fastest, options.speed), 0.0, room, remaining)
    # Not past the point within a step.
    speed = min(speed, distance / moving.step)
    turn = spin(moving, 2, np.arctan2(aside, ahead)) if moving.drive == OMNI_ANGULAR else 0.0
    return speed * across, speed * up, turn


@kernel
def axis_speed(moving: Moving, axis: int, part: float) -> float:
    """Return how fast a body can go in a direction [m/s], for the limits of one axis, of which that has some part."""
    if part == 0.0:
        return np.inf
    # Both signs negative for a negative part: low / part is the speed up to the lower limit.
    return float(max(moving.high[axis] / part if part > 0.0 else moving.low[axis] / part, 0.0))


@kernel
def spin(moving: Moving, axis: int, error: float) -> float:
    """Return the turn rate [rad/s] that turns a body by an angle [rad] soon, without going too far."""
    fastest = moving.high[axis] if error > 0.0 else -moving.low[axis]
    rate = braked_rate(max(fastest, 0.0), moving.change[axis], moving.step, np.abs(error))
    # Not past the angle within a step.
    rate = float(min(rate, np.abs(error) / moving.step))
    return rate if error > 0.0 else -rate


@kernel
def differential_command(
    options: Record, moving: Moving, ahead: float, aside: float, room: float, remaining: float, share: float
) -> Command:
    """Return speed and turn rate: on the spot where the point lies aside or behind, else along the arc to it.

    A body whose turn rate changes slowly goes by the heading that it would have when it came to rest.
    """
    rate = moving.velocity[1]
    # The angle that the body still turns through while it brakes its turn rate, w^2 / (2 a), with its sign.
    past = 0.5 * rate * np.abs(rate) / moving.change[1] if moving.change[1] > 0.0 else 0.0
    error = np.arctan2(aside, ahead)
    if max(np.abs(error), np.abs(error - past)) > options.turn_angle:
        return 0.0, spin(moving, 1, error), 0.0
    cosine, sine = np.cos(past), np.sin(past)
    ahead, aside = cosine * ahead + sine * aside, cosine * aside - sine * ahead
    curvature = arc_curvature(ahead, aside)
    speed = share * regulated_speed(options, min(moving.high[0], options.speed), curvature, room, remaining)
    sharpest = moving.high[1] if curvature > 0.0 else -moving.low[1]
    # Slower on a curve that the turn rate does not allow at this speed.
    if np.abs(curvature) * speed > sharpest:
        speed = max(sharpest, 0.0) / np.abs(curvature)
    speed = min(speed, np.sqrt(ahead * ahead + aside * aside) / moving.step)
    # The turn rate has to fit the speed that the acceleration allows, or the body leaves the arc.
    speed = executed(moving, 0, speed, moving.velocity[0])
    return speed, curvature * speed, 0.0


@kernel
def ackermann_command(
    options: Record, moving: Moving, ahead: float, aside: float, room: float, remaining: float, share: float
) -> Command:
    """Return a car's command on the arc to a point ahead, as nearly as it can; a negative share drives it back.

    Driving back it steers the other way, so that it turns towards the point.
    """
    left, right = moving.high[1], moving.low[1]
    if not moving.by_rate:
        left, right = min(left, STEEPEST), max(right, -STEEPEST)
    if share < 0.0:
        speed = max(
            share * regulated_speed(options, min(-moving.low[0], options.speed), 0.0, room, np.inf), moving.low[0]
        )
        to_left = aside > 0.0
        # A point straight behind can be turned to either way: it goes on turning as it does.
        if moving.velocity[0] < 0.0 and ahead < -np.abs(aside):
            # The second number is a turn rate (left: positive) or a steering angle (rolling back, left: negative).
            to_left = moving.velocity[1] > 0.0 if moving.by_rate else moving.velocity[1] < 0.0
        if moving.by_rate:
            return speed, left if to_left else right, 0.0
        return speed, right if to_left else left, 0.0
    curvature = arc_curvature(ahead, aside)
    speed = min(moving.high[0], options.speed)
    # A steered car cannot turn more sharply than its wheels; one with a turn rate goes slower instead.
    if not moving.by_rate:
        curvature = min(max(curvature, np.tan(right) / moving.wheelbase), np.tan(left) / moving.wheelbase)
    speed = share * regulated_speed(options, speed, curvature, room, remaining)
    speed = executed(moving, 0, min(speed, np.sqrt(ahead * ahead + aside * aside) / moving.step), moving.velocity[0])
    if moving.by_rate:
        return speed, min(max(curvature * speed, right), left), 0.0
    return speed, np.arctan(curvature * moving.wheelbase), 0.0


@kernel
def braking_command(moving: Moving) -> Command:
    """Return the command that stops a body as soon as it can, on the curve on which it is."""
    # What is left of the speed after a step of braking; the turn rate falls in proportion, which keeps the curvature.
    speed = executed(moving, 0, 0.0, moving.velocity[0])
    if moving.drive == ACKERMANN and not moving.by_rate:
        return 0.0, moving.velocity[1], 0.0
    if moving.drive in (DIFFERENTIAL, ACKERMANN):
        return 0.0, moving.velocity[1] * speed / moving.velocity[0] if moving.velocity[0] != 0.0 else 0.0, 0.0
    return 0.0, 0.0, 0.0


@kernel
def turn_command(moving: Moving, target: Point) -> Command:
    """Return the command with which a differential drive turns towards a point [m] where it is."""
    dx, dy = target[0] - moving.pose[0], target[1] - moving.pose[1]
    return 0.0, spin(moving, 1, wrap_below(np.arctan2(dy, dx) - moving.pose[2])), 0.0
