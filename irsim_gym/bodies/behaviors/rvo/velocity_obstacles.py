"""Velocity obstacles: cones of velocities that lead to a collision, and the choice among sampled velocities.

Velocity obstacles follow Fiorini and Shiller (1998), reciprocal ones van den Berg et al. (2008), hybrid ones Snape et
al. (2011). Velocities are sampled and weighed as in IR-SIM.
"""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Record, Records, Vector
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import record_type
from irsim_gym.bodies.behaviors.shared.surroundings import Ego

RVO, HRVO, VO = 0, 1, 2
"""Modes, in the order of the option ``mode``."""

CONE = record_type("apex_x apex_y left_x left_y right_x right_y left_slope right_slope", is_exact=np.int64)
"""A cone of forbidden velocities: its apex [m/s], the unit vectors along its left and right edge, their slopes, and
whether all this is as exact as can be. A velocity v is in it, edges included, if left x w <= 0 <= right x w for the
vector w = v - apex."""

PITCH = 0.05
"""Distance between neighbouring samples [m/s]."""

SLACK = 1.0 + 1e-12
"""What lies farther away than this times the best is not looked at: rounding cannot make it the best."""


class Axis(NamedTuple):
    """The velocities to try along one axis.

    Attributes:
        first: Lowest velocity [m/s].
        step: Difference between neighbouring velocities [m/s].
        n: Number of velocities.
        wanted: Wanted velocity [m/s].
    """

    first: float
    step: float
    n: int
    wanted: float


@kernel
def disc_cones(mode: int, ego: Ego, rounds: Records, cones: Records) -> None:
    """Write the cone of each disc and the length of the tangent to it; arguments as for ``disc_cone``."""
    for k in range(rounds.shape[0]):
        disc_cone(mode, ego, rounds[k], cones[k])


@kernel
def disc_cone(mode: int, ego: Ego, disc: Record, cone: Record) -> None:
    """Write the cone of a disc.

    The cone's edges are the tangents from the body's centre to a disc with the sum of both radii. The apex is the
    velocity of the disc (VO), or the mean of both velocities (RVO). HRVO moves the latter along one edge until the
    other edge is that of VO, on the side on which the body should not pass (Snape et al. 2011).

    Args:
        mode: RVO, HRVO or VO.
        ego: The body that decides.
        disc: The disc; ``touch_way`` is written.
        cone: Cone to write.
    """
    dx, dy, ux, uy, vx, vy = disc.x - ego.x, disc.y - ego.y, disc.vx, disc.vy, ego.vx, ego.vy
    sum_r = ego.radius + disc.radius
    distance = np.sqrt(dy * dy + dx * dx)
    disc.touch_way = np.sqrt(max(distance * distance - sum_r * sum_r, 0.0))
    # Half the opening of the cone; a body that overlaps the disc is as if it touched it, so it sees a half-plane.
    half = np.arcsin(min(max(sum_r / max(distance, sum_r), -1.0), 1.0))
    angle = np.arctan2(dy, dx)
    left, right = angle + half, angle - half
    apex_x, apex_y = ux, uy
    if mode != VO:
        apex_x, apex_y = (vx + ux) / 2.0, (vy + uy) / 2.0
    if mode == HRVO:
        off_x, off_y = apex_x - ux, apex_y - uy
        # sin(pi - 2 half) = sin(2 half); 0.01 keeps the quotient finite for a half-plane, as in IR-SIM.
        opening = np.pi - 2.0 * half
        if opening == 0.0:
            opening = 0.01
        # Law of sines: how far along the right edge of the one cone the line of the other cone's left edge lies.
        shift = np.sqrt(off_x * off_x + off_y * off_y) * np.sin(left - np.arctan2(off_y, off_x)) / np.sin(opening)
        # To the right of the axis: RVO's right edge and VO's left one, so that passing on the left costs more.
        if dx * (vy - apex_y) - (vx - apex_x) * dy <= 0.0:
            apex_x, apex_y = apex_x - shift * np.cos(right), apex_y - shift * np.sin(right)
        else:
            # RVO's left edge and VO's right one.
            apex_x, apex_y = ux + shift * np.cos(right), uy + shift * np.sin(right)
    write_cone(cone, (apex_x, apex_y), left, right)


@kernel
def side_cones(ego: Ego, sides: Floats, cones: Records, n_cones: int) -> int:
    """Append a cone for each standing segment: the directions in which the body's disc collides with it.

    Returns:
        New number of cones; a segment of length 0 adds none.
    """
    for k in range(sides.shape[0]):
        ax, ay, bx, by = sides[k, 0] - ego.x, sides[k, 1] - ego.y, sides[k, 2] - ego.x, sides[k, 3] - ego.y
        dx, dy = sides[k, 2] - sides[k, 0], sides[k, 3] - sides[k, 1]
        if dx * dx + dy * dy < 1e-12:
            continue
        first, second = np.arctan2(ay, ax), np.arctan2(by, bx)
        before, after = widening(ax, ay, ego.radius), widening(bx, by, ego.radius)
        # The angle from the first end to the second, wrapped; its sign says which end is to the left.
        turn = np.arctan2(np.sin(second - first), np.cos(second - first))
        if turn >= 0.0:
            write_cone(cones[n_cones], (0.0, 0.0), second + after, first - before)
        else:
            write_cone(cones[n_cones], (0.0, 0.0), first + before, second - after)
        n_cones += 1
    return n_cones


@kernel
def widening(dx: float, dy: float, r: float) -> float:
    """Return the angle [rad] by which a disc of radius r widens the direction of a point."""
    distance = np.sqrt(dx * dx + dy * dy)
    # Within the disc, the point blocks a half-plane.
    return float(np.arcsin(min(1.0, r / max(distance, r)))) if distance > 1e-6 else np.pi / 2.0


@kernel
def write_cone(cone: Record, apex: Vector, left: float, right: float) -> None:
    """Write a cone from its apex [m/s] and the angles [rad] of its edges."""
    left_x, left_y, right_x, right_y = np.cos(left), np.sin(left), np.cos(right), np.sin(right)
    set_cone(cone, apex[0], apex[1], left_x, left_y, right_x, right_y)
    cone.is_exact = 1


@kernel
def set_cone(
    cone: Record, apex_x: float, apex_y: float, left_x: float, left_y: float, right_x: float, right_y: float
) -> None:
    """Write a cone from its apex [m/s] and the unit vectors along its edges, and mark it as rough."""
    cone.apex_x, cone.apex_y, cone.is_exact = apex_x, apex_y, 0
    cone.left_x, cone.left_y, cone.right_x, cone.right_y = left_x, left_y, right_x, right_y
    cone.left_slope, cone.right_slope = left_y / left_x, right_y / right_x


@kernel
def lay_samples(current: float, change: float, limit: float, preferred: float) -> Axis:
    """Return the velocities to sample along one axis.

    They range from the lower end of the interval within ``change`` of ``current`` and within ``limit``, inclusive, to
    the upper end, exclusive. If the interval is empty, only the admissible velocity nearest to the current one is left.

    Args:
        current: Velocity now [m/s].
        change: Greatest change [m/s].
        limit: Greatest speed along the axis [m/s].
        preferred: The velocity that is wanted [m/s].
    """
    low, high = max(current - change, -limit), min(current + change, limit)
    # np.arange, with which IR-SIM samples, repeats the rounded difference of its first two values.
    step = (low + PITCH) - low
    if high <= low:
        return Axis(min(max(current, -limit), limit), step, 1, preferred)
    return Axis(low, step, int(np.ceil((high - low) / PITCH)), preferred)


@kernel
def write_samples(axis: Axis, samples: Floats, order: Ints) -> None:
    """Write the samples along an axis in ascending order, and their indices by distance from the wanted one [m/s]."""
    for k in range(axis.n):
        samples[k] = axis.first + k * axis.step
    order_samples(samples, axis.n, axis.wanted, order)


@kernel
def order_samples(samples: Floats, count: int, preferred: float, order: Ints) -> None:
    """Write the indices of ascending samples, ordered by their distance from the wanted velocity [m/s]."""
    above = 0
    while above < count and samples[above] < preferred:
        above += 1
    # Two runs, downwards from `below` and upwards from `above`, are merged by distance; ties go to the lower index.
    below = above - 1
    for k in range(count):
        if above >= count or (below >= 0 and preferred - samples[below] <= samples[above] - preferred):
            order[k] = below
            below -= 1
        else:
            order[k] = above
            above += 1
