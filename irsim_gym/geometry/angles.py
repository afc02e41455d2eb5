"""Angles: wrapping, and the cosine and sine of a heading."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.jit import kernel

TURN = 2.0 * np.pi
NEAR_TURNS = 4


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
def turned(heading: float, known: Floats) -> tuple[float, float]:
    """Return cosine and sine of a heading [rad].

    Args:
        heading: The heading.
        known: Cosine and sine of a heading, and that heading [rad]. If it equals ``heading``, these are returned. Zeros
            if nothing is known.
    """
    if known[2] == heading and known[0] * known[0] + known[1] * known[1] > 0.0:
        return known[0], known[1]
    return np.cos(heading), np.sin(heading)
