"""Regulated pure pursuit (Macenski, Singh, Martin, Gines 2023: Regulated pure pursuit for robot path tracking)."""

import numpy as np

from irsim_gym.base.arraytypes import Record
from irsim_gym.base.kernels import kernel


@kernel
def lookahead_distance(options: Record, speed: float) -> float:
    """Return how far ahead on the way the body looks [m]: as far as it goes in ``lookahead_time``, within bounds.

    Args:
        options: ``lookahead_time``, ``lookahead_min``, ``lookahead_max`` of ``Pursuit``.
        speed: The speed at which it drives [m/s].
    """
    # NaN, which does not equal itself, stands for no bound.
    most = options.lookahead_max if options.lookahead_max == options.lookahead_max else np.inf
    return float(max(min(speed * options.lookahead_time, most), options.lookahead_min))


@kernel
def arc_curvature(ahead: float, aside: float) -> float:
    """Return the curvature [1/m] of the arc from the body to a point, which begins in the direction of its heading.

    2 y / (x^2 + y^2), positive to the left; 0 for the body's own place.

    Args:
        ahead: x of the point in the body's frame [m].
        aside: y of the point in the body's frame [m].
    """
    far2 = ahead * ahead + aside * aside
    return 2.0 * aside / far2 if far2 > 0.0 else 0.0


@kernel
def regulated_speed(options: Record, speed: float, curvature: float, room: float, remaining: float) -> float:
    """Return the speed [m/s]: the lower one of two that regulate it, not below a least one, and slower at the end.

    In curves of radius r below ``min_radius`` r_min it is v r / r_min; at a distance d below ``proximity`` d_prox of an
    obstacle it is v gain d / d_prox; at the end of the way within ``approach`` v times the share of it that remains.

    Args:
        options: Those of ``Pursuit``.
        speed: The speed that is wanted [m/s].
        curvature: Of the arc ahead [1/m].
        room: Distance of the body's surface from the nearest obstacle [m].
        remaining: What remains of the way [m].
    """
    # r_min / r: how many times slower than on a straight line.
    bend = np.abs(curvature) * options.min_radius
    by_curvature = speed / bend if bend > 1.0 else speed
    by_proximity = speed * options.proximity_gain * room / options.proximity if room < options.proximity else speed
    regulated = max(min(by_curvature, by_proximity), min(options.min_speed, speed))
    if remaining < options.approach:
        regulated = min(regulated, max(speed * remaining / options.approach, min(options.approach_speed, speed)))
    return float(regulated)
