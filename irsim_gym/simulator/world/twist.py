"""How drives read their velocities: as a twist of the body."""

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_WORLD

Twist = tuple[float, float, float]
"""Velocity ahead and to the left [m/s], turn rate [rad/s]."""


@kernel
def body_twist(
    velocity: tuple[float, float, float] | Floats,
    steering: float,
    cosine: float,
    sine: float,
    drive: int,
    wheelbase: float,
) -> Twist:
    """Return the twist of a body that executes a velocity.

    Args:
        velocity: The velocity in drive coordinates; that of a car begins with its speed.
        steering: Angle at which a car rolls [rad].
        cosine: Cosine of the heading.
        sine: Sine of the heading.
        drive: How the velocity reads, see ``simulator.world.model``.
        wheelbase: Axle distance of a car [m]; 0 if the second number is a turn rate.
    """
    first, second = velocity[0], velocity[1]
    if drive == DIFFERENTIAL:
        return first, 0.0, second
    if drive == ACKERMANN:
        # Kinematic bicycle model, with the body's origin on the rear axle.
        if wheelbase > 0.0:
            return first, 0.0, first * np.tan(steering) / wheelbase
        # A car that stands cannot turn.
        return first, 0.0, second if first != 0.0 else 0.0
    if drive == OMNI_WORLD:
        return cosine * first + sine * second, cosine * second - sine * first, 0.0
    return first, second, velocity[2] if drive == OMNI_ANGULAR else 0.0
