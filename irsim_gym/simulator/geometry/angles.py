"""Angles: wrapping, and the cosine and sine of a heading."""

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.kernels import kernel

TURN = 2.0 * np.pi
NEAR_TURNS = 4
TINY = 1e-300
"""Shorter vectors have no angle."""


@kernel(inlined=True)
def wrap(angle: float) -> float:
    """Return the angle [rad] in (-pi, pi]. An angle in this interval is returned unchanged."""
    if -np.pi < angle <= np.pi:
        return angle
    wrapped = angle - TURN * np.ceil((angle - np.pi) / TURN)
    # Rounding may end on either side of the interval.
    if wrapped <= -np.pi:
        return np.pi
    return float(min(wrapped, np.pi) if wrapped == wrapped else wrapped)


@kernel(inlined=True)
def wrap_below(angle: float) -> float:
    """Return the angle [rad] in [-pi, pi), as IR-SIM wraps headings.

    An angle in this interval is returned unchanged.
    """
    if -np.pi <= angle < np.pi:
        return angle
    return float((angle + np.pi) % TURN - np.pi)


@kernel(inlined=True)
def wrap_from(angle: float, low: float) -> float:
    """Return the angle [rad] in [low, low + 2 pi], both ends included.

    An angle in this interval is returned unchanged. A few turns are removed one by one, as in IR-SIM, which rounds
    alike; many at once.
    """
    high = low + TURN
    if low <= angle <= high:
        return angle
    if angle > high + NEAR_TURNS * TURN or angle < low - NEAR_TURNS * TURN:
        angle = angle - TURN * np.floor((angle - low) / TURN)
    for _ in range(NEAR_TURNS + 1):
        if angle > high:
            angle -= TURN
        elif angle < low:
            angle += TURN
    return angle


@kernel(inlined=True)
def turned(heading: float, direction: Floats) -> tuple[float, float]:
    """Return cosine and sine of a heading [rad].

    Args:
        heading: The heading.
        direction: Cosine and sine of a heading, and that heading [rad]. If it equals ``heading``, these are returned.
            Zeros if nothing is known.
    """
    # Whoever writes a pose need not report it: its heading differs from that of the numbers, which are then not used.
    if direction[2] == heading and direction[0] * direction[0] + direction[1] * direction[1] > 0.0:
        return direction[0], direction[1]
    return np.cos(heading), np.sin(heading)


@kernel(inlined=True)
def nearly_arctan2(y: float, x: float) -> float:
    """Return the angle of a vector [rad] in [-pi, pi], with an error of at most 2e-8, in a third of the time.

    On the axes it is exact. Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 4.4.49.
    """
    across, up = abs(x), abs(y)
    ratio = min(across, up) / max(across, up, TINY)
    s = ratio * ratio
    # Powers of s from the highest on.
    series = 0.1065626393 + s * (-0.0752896400 + s * (0.0429096138 + s * (-0.0161657367 + s * 0.0028662257)))
    series = s * (-0.3333314528 + s * (0.1999355085 + s * (-0.1420889944 + s * series)))
    angle = ratio + ratio * series
    if up > across:
        angle = 0.5 * np.pi - angle
    if x < 0.0:
        angle = np.pi - angle
    return float(np.copysign(angle, y))
