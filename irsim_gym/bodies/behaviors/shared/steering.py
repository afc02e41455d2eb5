"""Compute the velocity to a goal in the world frame, and a drive's command from a velocity."""

from typing import NamedTuple

import numpy as np

from irsim_gym.simulator.geometry.angles import wrap_below
from irsim_gym.simulator.world.model import DIFFERENTIAL, OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD
from irsim_gym.simulator.world.names import Flags, Floats, Group, Model, State, Vector, kernel, row_of

ARRIVED = 0.1
"""Nearer to the goal than this [m] no velocity is wanted."""


class Turning(NamedTuple):
    """How a differential drive follows a velocity.

    Attributes:
        time: Time in which it turns to face the velocity [s].
        tolerance: It does not turn for a smaller angle than this [rad].
        slow: It stands still for velocities up to this [m/s].
        limit: Maximum turn rate [rad/s].
    """

    time: float
    tolerance: float
    slow: float
    limit: float


def commanded_by_rate(group: Group) -> Flags:
    """Return for each member whether its command has a turn rate, not a steering angle; shape ``(n_members,)``."""
    bodies = () if group.context is None else group.context.bodies
    modes = [getattr(bodies[b].kinematics, "mode", "") if bodies else "" for b in group.members.tolist()]
    return np.array([mode == "angular" for mode in modes], np.bool_)


@kernel
def goal_offset(state: State, w: int, b: int) -> Vector:
    """Return the vector from a body to its goal in the world frame [m].

    Reads: state (goal, pose).
    """
    return state.goal[w, b, 0] - state.pose[w, b, 0], state.goal[w, b, 1] - state.pose[w, b, 1]


@kernel
def clear_command(state: State, w: int, b: int) -> None:
    """Write a zero command.

    Writes: state (command).
    """
    state.command[w, b, 0], state.command[w, b, 1], state.command[w, b, 2] = 0.0, 0.0, 0.0


@kernel
def wanted_velocity(model: Model, state: State, w: int, b: int) -> Vector:
    """Return the velocity straight to the goal [m/s], 0 at the goal.

    An omnidirectional drive has a speed for each axis of the world.

    Reads: model (drive, velocity_max), state (goal, pose).
    """
    dx, dy = goal_offset(state, w, b)
    if np.sqrt(dx * dx + dy * dy) <= ARRIVED:
        return 0.0, 0.0
    fastest = model.velocity_max[row_of(model.velocity_max, w), b]
    # IR-SIM wraps the angle in this way. Its rounding decides which of two equally good samples `rvo` takes.
    angle = (np.arctan2(dy, dx) + np.pi) % (2.0 * np.pi) - np.pi
    speed_y = fastest[0] if model.drive[b] == DIFFERENTIAL else fastest[1]
    return fastest[0] * np.cos(angle), speed_y * np.sin(angle)


@kernel
def to_command(drive: int, heading: float, vx: float, vy: float, turning: Turning, command: Floats) -> None:
    """Write the command that makes a drive follow a velocity; zero for a drive that cannot (Ackermann, none).

    Omnidirectional drives execute the velocity as it is and do not turn. A differential drive turns towards the
    direction of the velocity within ``turning.time`` and drives at its forward component, as in IR-SIM.

    Args:
        drive: Drive of the body; see ``simulator.world.model``.
        heading: Direction of the body's x axis [rad].
        vx: X component of the velocity in the world frame [m/s].
        vy: Y component of the velocity in the world frame [m/s].
        turning: How a differential drive turns.
        command: Command to write, shape ``(3,)``; components that the drive does not have are 0.
    """
    command[0], command[1], command[2] = 0.0, 0.0, 0.0
    if drive == OMNI_WORLD:
        command[0], command[1] = vx, vy
    elif drive in (OMNI_BODY, OMNI_ANGULAR):
        cosine, sine = np.cos(heading), np.sin(heading)
        command[0], command[1] = cosine * vx + sine * vy, cosine * vy - sine * vx
    elif drive == DIFFERENTIAL:
        speed = np.sqrt(vx * vx + vy * vy)
        if speed <= turning.slow:
            return
        error = wrap_below(heading - np.arctan2(vy, vx))
        # A body that points away from the velocity turns on the spot first, instead of driving backwards.
        command[0] = max(speed * np.cos(error), 0.0)
        if np.abs(error) >= turning.tolerance:
            command[1] = max(min(-error / turning.time, turning.limit), -turning.limit)


@kernel
def braked_rate(fastest: float, acceleration: float, step: float, angle: float) -> float:
    """Return the greatest turn rate [rad/s] from which a body can stop within an angle, at most ``fastest``.

    With the acceleration a and steps of length dt, a body that turns at the rate r covers r^2 / (2 a) + r dt until it
    stands; the rate is the root of this for the angle.

    Args:
        fastest: Maximum turn rate of the body [rad/s].
        acceleration: Maximum change of the turn rate [rad/s2]; infinite or 0 for no limit.
        step: Duration of a step [s].
        angle: Remaining angle [rad].
    """
    if not (np.isfinite(acceleration) and acceleration > 0.0):
        return fastest
    # The positive root of r^2 / (2 a) + r dt = angle. The term r dt is the step before braking can begin.
    braking = acceleration * step
    return float(min(fastest, np.sqrt(braking * braking + 2.0 * acceleration * angle) - braking))
