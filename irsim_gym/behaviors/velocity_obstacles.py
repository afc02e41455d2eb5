"""Velocity obstacles: cones of velocities that lead to a collision, and the choice among sampled velocities.

Velocity obstacles after Fiorini and Shiller (1998), reciprocal ones after van den Berg et al. (2008), hybrid ones
after Snape et al. (2011), sampled and weighed as IR-SIM does.
"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.jit import kernel

RVO, HRVO, VO = 0, 1, 2

CONE = 9
"""Numbers of a cone."""

PITCH = 0.05
"""Distance between neighbouring samples [m/s]."""

SLACK = 1.0 + 1e-12
"""What lies farther away than this times the best is not looked at: rounding cannot make it the best."""

NO_TIME = 1e-4
"""Time to a collision [s] that has begun already."""

NEVER = 1e6
"""Time to a collision with a wall [s] that is not met."""


@kernel
def disc_cones(
    mode: int, x: float, y: float, vx: float, vy: float, r: float, rounds: Floats, n_rounds: int, cones: Floats
) -> None:
    """Write the cone and the way to a touch of each disc; arguments as below."""
    for k in range(n_rounds):
        disc_cone(mode, x, y, vx, vy, r, k, rounds, cones)


@kernel
def disc_cone(
    mode: int, x: float, y: float, vx: float, vy: float, r: float, k: int, rounds: Floats, cones: Floats
) -> None:
    """Write the cone of disc k.

    Args:
        mode: RVO, HRVO or VO.
        x: Position [m].
        y: Position [m].
        vx: Velocity [m/s].
        vy: Velocity [m/s].
        r: Radius [m].
        k: Number of the disc.
        rounds: x, y, vx, vy, radius of the discs [m, m/s]; column 5 is written: the way to a touch [m].
        cones: Written, shape ``(n, CONE)``.
    """
    dx, dy, ux, uy = rounds[k, 0] - x, rounds[k, 1] - y, rounds[k, 2], rounds[k, 3]
    sum_r = r + rounds[k, 4]
    distance = np.sqrt(dy * dy + dx * dx)
    rounds[k, 5] = np.sqrt(max(distance * distance - sum_r * sum_r, 0.0))
    half = np.arcsin(min(max(sum_r / max(distance, sum_r), -1.0), 1.0))
    angle = np.arctan2(dy, dx)
    left, right = angle + half, angle - half
    apex_x, apex_y = ux, uy
    if mode != VO:
        apex_x, apex_y = (vx + ux) / 2.0, (vy + uy) / 2.0
    if mode == HRVO:
        off_x, off_y = apex_x - ux, apex_y - uy
        opening = np.pi - 2.0 * half
        if opening == 0.0:
            opening = 0.01
        shift = np.sqrt(off_x * off_x + off_y * off_y) * np.sin(left - np.arctan2(off_y, off_x)) / np.sin(opening)
        if dx * (vy - apex_y) - (vx - apex_x) * dy <= 0.0:
            apex_x, apex_y = apex_x - shift * np.cos(right), apex_y - shift * np.sin(right)
        else:
            apex_x, apex_y = ux + shift * np.cos(right), uy + shift * np.sin(right)
    write_cone(cones[k], apex_x, apex_y, left, right)


@kernel
def side_cones(x: float, y: float, r: float, sides: Floats, n_sides: int, cones: Floats, n_cones: int) -> int:
    """Append one cone for each standing segment: the directions in which a disc of radius r [m] runs into it.

    Returns:
        How many cones there are now; segments that are a point have none.
    """
    for k in range(n_sides):
        ax, ay, bx, by = sides[k, 0], sides[k, 1], sides[k, 2], sides[k, 3]
        if (bx - ax) * (bx - ax) + (by - ay) * (by - ay) < 1e-12:
            continue
        first, second = np.arctan2(ay - y, ax - x), np.arctan2(by - y, bx - x)
        before = widening(ax - x, ay - y, r)
        after = widening(bx - x, by - y, r)
        turn = np.arctan2(np.sin(second - first), np.cos(second - first))
        if turn >= 0.0:
            write_cone(cones[n_cones], 0.0, 0.0, second + after, first - before)
        else:
            write_cone(cones[n_cones], 0.0, 0.0, first + before, second - after)
        n_cones += 1
    return n_cones


@kernel
def widening(dx: float, dy: float, r: float) -> float:
    """Return the angle [rad] by which a disc of radius r widens the direction of a point."""
    distance = np.sqrt(dx * dx + dy * dy)
    return float(np.arcsin(min(1.0, r / max(distance, r)))) if distance > 1e-6 else np.pi / 2.0


@kernel
def write_cone(cone: Floats, apex_x: float, apex_y: float, left: float, right: float) -> None:
    """Write a cone from the angles [rad] of its edges.

    Args:
        cone: Written: apex [m/s], direction of the left and of the right edge, their slopes, and that all this is as
            exact as can be; shape ``(CONE,)``. A velocity v is in the cone, edges included, if with w = v - apex
            left x w <= 0 <= right x w.
        apex_x: Apex [m/s].
        apex_y: Apex [m/s].
        left: Angle of the left edge [rad].
        right: Angle of the right edge [rad].
    """
    cone[0], cone[1] = apex_x, apex_y
    cone[2], cone[3] = np.cos(left), np.sin(left)
    cone[4], cone[5] = np.cos(right), np.sin(right)
    cone[6], cone[7], cone[8] = cone[3] / cone[2], cone[5] / cone[4], 1.0


@kernel
def lay_samples(current: float, change: float, limit: float) -> tuple[float, float, int]:
    """Return the first of the velocities to try along one axis [m/s], the step to the next one, and their number.

    They begin at the lower end of what is within ``change`` of ``current`` and within ``limit``, and stop before the
    upper one; where there is nothing the admissible velocity nearest to the current one is left.

    Args:
        current: Velocity now [m/s].
        change: Greatest change [m/s].
        limit: Greatest speed along the axis [m/s].
    """
    low, high = max(current - change, -limit), min(current + change, limit)
    step = (low + PITCH) - low  # as np.arange: the pitch is that of the first two
    if high <= low:
        return min(max(current, -limit), limit), step, 1
    return low, step, int(np.ceil((high - low) / PITCH))


@kernel
def write_samples(first: float, step: float, count: int, wanted: float, samples: Floats, order: Ints) -> None:
    """Write the velocities to try along an axis, ascending, and their indices by distance from the wanted one [m/s]."""
    for k in range(count):
        samples[k] = first + k * step
    order_samples(samples, count, wanted, order)


@kernel
def order_samples(samples: Floats, count: int, wanted: float, order: Ints) -> None:
    """Write the indices of ascending samples in the order of their distance from the wanted velocity [m/s]."""
    above = 0
    while above < count and samples[above] < wanted:
        above += 1
    below = above - 1
    for k in range(count):
        if above >= count or (below >= 0 and wanted - samples[below] <= samples[above] - wanted):
            order[k] = below
            below -= 1
        else:
            order[k] = above
            above += 1


@kernel
def least_penalty(
    x: float,
    y: float,
    vx: float,
    vy: float,
    r: float,
    rounds: Floats,
    n_rounds: int,
    sides: Floats,
    n_sides: int,
    factor: float,
    samples: Floats,
    n_x: int,
    n_y: int,
    wanted_x: float,
    wanted_y: float,
    order: Ints,
) -> int:
    """Return the sample with the least ``factor / time to the first collision + distance from the wanted velocity``.

    Arguments as above; of several samples that are equally good the first counts.
    """
    best, best_cost, least = 0, np.inf, 0.0
    for k in range(n_rounds):
        if rounds[k, 5] == 0.0:  # touches already: every sample costs the same for it
            least = factor * (1.0 / NO_TIME)
    for a in range(n_x):
        i = order[0, a]
        dx = samples[0, i] - wanted_x
        if least + np.abs(dx) > best_cost * SLACK:
            break
        for c in range(n_y):
            j = order[1, c]
            distance = np.hypot(dx, samples[1, j] - wanted_y)
            if least + distance > best_cost * SLACK:
                break
            time = np.inf
            if least > 0.0:
                time = 0.0
            else:
                ux, uy = samples[0, i], samples[1, j]
                for k in range(n_rounds):
                    tx, ty = 2.0 * ux - vx - rounds[k, 2], 2.0 * uy - vy - rounds[k, 3]
                    time = min(time, rounds[k, 5] / (np.sqrt(tx * tx + ty * ty) + 1e-7))
                for k in range(n_sides):
                    time = min(time, time_to_side(x, y, r, ux, uy, sides[k]))
            cost = factor * (1.0 / (NO_TIME if time == 0.0 else time)) + distance
            place = i * n_y + j
            if cost < best_cost or (cost == best_cost and place < best):
                best, best_cost = place, cost
    return best


@kernel
def time_to_side(x: float, y: float, r: float, vx: float, vy: float, side: Floats) -> float:
    """Return when a disc that moves straight on meets a segment [s]: its line, up to r beyond its ends."""
    along_x, along_y = side[2] - side[0], side[3] - side[1]
    length = np.sqrt(along_x * along_x + along_y * along_y)
    if length < 1e-12:
        return NEVER
    normal_x, normal_y = -along_y / length, along_x / length
    height = normal_x * (x - side[0]) + normal_y * (y - side[1])
    if height < 0.0:
        normal_x, normal_y, height = -normal_x, -normal_y, -height
    approach = -(normal_x * vx + normal_y * vy)
    if approach <= 1e-7:
        return NEVER
    time = max((height - r) / approach, 0.0)
    share = ((x + vx * time - side[0]) * along_x + (y + vy * time - side[1]) * along_y) / (length * length)
    margin = r / length
    return float(time) if -margin <= share <= 1.0 + margin else NEVER
