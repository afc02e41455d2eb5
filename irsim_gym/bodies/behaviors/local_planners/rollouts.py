"""Rollouts of constant commands, and their distances from a scan's points, for local planners.

All coordinates are in the body's present frame: x ahead, y to the left [m].
"""

import numpy as np

from irsim_gym.bodies.behaviors.pursuit.motion import Moving
from irsim_gym.simulator.geometry.overlap import is_round, point_outline_distance
from irsim_gym.simulator.world.names import BodyOutline, Floats, Record, Vector, kernel, record_type
from irsim_gym.simulator.world.twist import Twist, body_twist

LANES = 16
"""Number of poses that are compared with a point at once."""

ROUNDING = 1e-9
"""Relative tolerance of squared distances for rounding."""

POSES = record_type("x y cosine sine near", LANES)
"""Poses [m], and the squared distance of each from the nearest point [m2]."""


@kernel
def twist_of(moving: Moving, facing: Vector, first: float, second: float) -> Twist:
    """Return the twist with which a body executes a command, with the cosine and the sine of its heading.

    An Ackermann drive is taken to steer at once, although its wheels follow one step later.
    """
    wheelbase = 0.0 if moving.by_rate else moving.wheelbase
    return body_twist((first, second, 0.0), second, facing[0], facing[1], moving.drive, wheelbase)


@kernel
def place_at(twist: Twist, time: float) -> tuple[float, float, float, float]:
    """Return x, y [m], cosine and sine of the heading after some time with a constant twist: on a circle, or straight.

    Args:
        twist: The twist.
        time: The time [s].
    """
    ahead, left, rate = twist
    turn = rate * time
    cosine, sine = np.cos(turn), np.sin(turn)
    # The chord of a unit-speed arc in the initial frame: sin(turn) / rate ahead and (1 - cos(turn)) / rate to the left.
    along, across = (sine / rate, (1.0 - cosine) / rate) if rate != 0.0 else (time, 0.0)
    return ahead * along - left * across, ahead * across + left * along, cosine, sine


@kernel
def lay_poses(twist: Twist, first: int, step: float, poses: Record) -> None:
    """Write where a twist leads at LANES moments: from ``first + 1`` steps on [s].

    Writes: poses.
    """
    for k in range(LANES):
        poses.x[k], poses.y[k], poses.cosine[k], poses.sine[k] = place_at(twist, (first + k + 1) * step)


@kernel
def find_nearest(points: Floats, n_points: int, poses: Record) -> None:
    """Write the squared distance of each pose from the nearest of some points, infinite without any.

    Writes: poses.

    Args:
        points: x and y [m], shape ``(2, n)``.
        n_points: Number of points.
        poses: The poses; ``near`` is written.
    """
    for k in range(LANES):
        poses.near[k] = np.inf
    for j in range(n_points):
        x, y = points[0, j], points[1, j]
        for k in range(LANES):
            dx, dy = poses.x[k] - x, poses.y[k] - y
            distance2 = dx * dx + dy * dy
            # Selections in place of branches, so that all lanes take one path.
            poses.near[k] = distance2 if distance2 < poses.near[k] else poses.near[k]


@kernel
def gap_at(
    outline: BodyOutline, reach: float, limit: float, points: Floats, n_points: int, poses: Record, k: int
) -> float:
    """Return the distance [m] of an outline at pose k from the nearest point, 0 if it is within; at most ``limit``.

    Args:
        outline: The outline in the body frame.
        reach: Radius about the body's origin that holds it [m].
        limit: Distances above this are reported as this [m].
        points: x and y [m], shape ``(2, n)``.
        n_points: Number of points.
        poses: The poses, with ``near`` as ``find_nearest`` writes it.
        k: Which pose.
    """
    # The outline lies within `reach` of the origin, so points farther away than this cannot be closer than `limit`.
    far = reach + limit
    if poses.near[k] >= far * far:
        return limit
    if is_round(outline):
        return float(max(np.sqrt(poses.near[k]) - reach, 0.0))
    best = limit
    # First the point nearest to the origin alone: the distance found there excludes most others in the second pass.
    for within in (poses.near[k] * (1.0 + ROUNDING), far * far):
        for j in range(n_points):
            dx, dy = points[0, j] - poses.x[k], points[1, j] - poses.y[k]
            distance2 = dx * dx + dy * dy
            if distance2 <= within and distance2 < (reach + best) * (reach + best):
                # The outline is given in the body frame, so the point is turned into it, not the outline out of it.
                x, y = poses.cosine[k] * dx + poses.sine[k] * dy, poses.cosine[k] * dy - poses.sine[k] * dx
                best = min(best, point_outline_distance((x, y), outline))
    return best


@kernel
def spread_over(low: float, high: float, i: int, count: int) -> float:
    """Return the i-th of some values from low to high, evenly spread; mirrored bounds give mirrored values."""
    if count == 1:
        return 0.5 * (low + high)
    return (low * (count - 1 - i) + high * i) / (count - 1)
