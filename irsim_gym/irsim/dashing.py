"""IR-SIM's ``dash`` as functions, for behaviours of one's own. States, goals and limits are flat or columns."""

import math

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.irsim.rotations import WrapToPi, as_row, relative_position


def DiffDash(  # noqa: N802
    state: ArrayLike,
    goal: ArrayLike,
    max_vel: ArrayLike,
    goal_threshold: float = 0.1,
    angle_tolerance: float = 0.2,
    angular_acce: float = math.inf,
    dt: float = 0.0,
) -> Floats:
    """Return the command (linear, angular) of a differential drive to its goal [m/s, rad/s], shape ``(2, 1)``.

    Args:
        state: x, y, heading [m, m, rad].
        goal: x, y [m].
        max_vel: Greatest velocities [m/s, rad/s].
        goal_threshold: Nearer to the goal than this, it stands [m].
        angle_tolerance: It does not turn for a smaller angle [rad].
        angular_acce: With this deceleration, it turns no faster than it can brake [rad/s2].
        dt: Duration of a step [s].
    """
    (speed, rate), away, error = as_row(max_vel), *_bearing(state, goal)
    if away < goal_threshold:
        return np.zeros((2, 1))
    turn = _turn_rate(error, rate, angle_tolerance, angular_acce, dt)
    return np.array([[speed * math.cos(error)], [turn]])


def OmniDash(state: ArrayLike, goal: ArrayLike, max_vel: ArrayLike, goal_threshold: float = 0.1) -> Floats:  # noqa: N802
    """Return the velocity ahead and to the left to a goal [m/s], shape ``(2, 1)``, as ``frame: body`` takes it.

    Args:
        state: x, y [m], and perhaps the heading [rad].
        goal: x, y [m].
        max_vel: Greatest velocities [m/s].
        goal_threshold: Up to this distance from the goal, it stands [m].
    """
    away, error = _bearing(state, goal)
    ahead, left = as_row(max_vel)[:2]
    stands = away <= goal_threshold
    return np.zeros((2, 1)) if stands else np.array([[ahead * math.cos(error)], [left * math.sin(error)]])


def OmniAngularDash(  # noqa: N802
    state: ArrayLike,
    goal: ArrayLike,
    max_vel: ArrayLike,
    goal_threshold: float = 0.3,
    angle_tolerance: float = 0.1,
    angular_acce: float = math.inf,
    dt: float = 0.0,
) -> Floats:
    """Return velocities ahead and to the left, and the turn rate, to a goal and its heading, shape ``(3, 1)``.

    Args:
        state: x, y, heading [m, m, rad].
        goal: x, y [m], and perhaps a heading [rad].
        max_vel: Greatest velocities [m/s, m/s, rad/s].
        goal_threshold: Up to this distance from the goal, it only turns [m].
        angle_tolerance: It does not turn for a smaller angle [rad].
        angular_acce: With this deceleration, it turns no faster than it can brake [rad/s2].
        dt: Duration of a step [s].
    """
    velocity, heading, target = OmniDash(state, goal, max_vel, goal_threshold), as_row(state)[2], as_row(goal)
    error = _bearing(state, goal)[1]
    if relative_position(state, goal)[0] <= goal_threshold:
        error = WrapToPi(target[2] - heading) if len(target) > 2 else 0.0
    turn = _turn_rate(error, as_row(max_vel)[2], angle_tolerance, angular_acce, dt)
    return np.vstack([velocity, [[turn]]])


def AckerDash(  # noqa: N802
    state: ArrayLike, goal: ArrayLike, max_vel: ArrayLike, goal_threshold: float, angle_tolerance: float
) -> Floats:
    """Return the command (linear, steering angle) of a car to its goal [m/s, rad], shape ``(2, 1)``.

    Args:
        state: x, y, heading [m, m, rad].
        goal: x, y [m].
        max_vel: Greatest speed and steering angle [m/s, rad].
        goal_threshold: Nearer to the goal than this, it stands [m].
        angle_tolerance: It does not steer for a smaller angle [rad].
    """
    (speed, steepest), away, error = as_row(max_vel), *_bearing(state, goal)
    if away < goal_threshold:
        return np.zeros((2, 1))
    steering = 0.0 if abs(error) < angle_tolerance else min(max(error, -steepest), steepest)
    return np.array([[speed], [steering]])


def _bearing(state: ArrayLike, goal: ArrayLike) -> tuple[float, float]:
    """Return the distance of a goal [m], and its direction from the heading [rad]."""
    away, direction = relative_position(state, goal)
    return away, WrapToPi(direction - np.append(as_row(state), 0.0)[2])


def _turn_rate(error: float, fastest: float, tolerance: float, deceleration: float, dt: float) -> float:
    """Return the turn rate towards an angle [rad/s]: the greatest from which it can still stop there."""
    if abs(error) < tolerance:
        return 0.0
    rate = abs(fastest)
    if math.isfinite(deceleration) and deceleration > 0.0:
        # The positive root of rate^2 / (2 a) + rate dt = angle: braking begins after this step.
        braking = deceleration * dt
        rate = min(rate, math.sqrt(braking**2 + 2.0 * deceleration * (abs(error) - tolerance)) - braking)
    return math.copysign(rate, error)
