"""Velocity obstacles: cones of velocities that lead to a collision, and the choice among sampled velocities.

Velocity obstacles after Fiorini and Shiller (1998), reciprocal ones after van den Berg et al. (2008), hybrid ones
after Snape et al. (2011), sampled and weighed as IR-SIM does.
"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.jit import kernel

RVO, HRVO, VO = 0, 1, 2

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
) -> int:
    """Write one cone for each disc; return how many.

    Args:
        mode: RVO, HRVO or VO.
        x: Position [m].
        y: Position [m].
        vx: Velocity [m/s].
        vy: Velocity [m/s].
        r: Radius [m].
        rounds: x, y, vx, vy, radius of the discs [m, m/s]; column 5 is written: the way to a touch [m].
        n_rounds: Number of discs.
        cones: Written: apex, direction of the left and of the right edge, shape ``(n, 6)``.
    """
    for k in range(n_rounds):
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
    return n_rounds


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
    """Write apex and edges of a cone, shape ``(6,)``, from the angles [rad] of its edges."""
    cone[0], cone[1] = apex_x, apex_y
    cone[2], cone[3] = np.cos(left), np.sin(left)
    cone[4], cone[5] = np.cos(right), np.sin(right)


@kernel
def in_cone(cone: Floats, vx: float, vy: float) -> bool:
    """Return whether a velocity lies in a cone; its edges belong to it."""
    wx, wy = vx - cone[0], vy - cone[1]
    return bool(cone[2] * wy - wx * cone[3] <= 0.0 and cone[4] * wy - wx * cone[5] >= 0.0)


@kernel
def lay_samples(current: float, change: float, limit: float, samples: Floats) -> int:
    """Write the velocities to try along one axis, ascending; return how many.

    They begin at the lower end of what is within ``change`` of ``current`` and within ``limit``, and stop before the
    upper one; where there is nothing the admissible velocity nearest to the current one is left.

    Args:
        current: Velocity now [m/s].
        change: Greatest change [m/s].
        limit: Greatest speed along the axis [m/s].
        samples: Written [m/s].
    """
    low, high = max(current - change, -limit), min(current + change, limit)
    if high <= low:
        samples[0] = min(max(current, -limit), limit)
        return 1
    count = int(np.ceil((high - low) / PITCH))
    step = (low + PITCH) - low  # as np.arange: the pitch is that of the first two
    for k in range(count):
        samples[k] = low + k * step
    return count


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
def nearest_free(
    cones: Floats,
    n_cones: int,
    samples: Floats,
    n_x: int,
    n_y: int,
    wanted_x: float,
    wanted_y: float,
    order: Ints,
) -> int:
    """Return the sample outside of all cones that is nearest to the wanted velocity, -1 without any.

    Samples are numbered x-major; of several that are equally near the first counts. They are looked at from the
    wanted velocity outwards, so most are never looked at.

    Args:
        cones: Apexes and edges, shape ``(n, 6)``.
        n_cones: Number of them.
        samples: Velocities along x and y [m/s], shape ``(2, n)``.
        n_x: Number of samples along x.
        n_y: Number of samples along y.
        wanted_x: Wanted velocity [m/s].
        wanted_y: Wanted velocity [m/s].
        order: Indices of the samples by distance from the wanted velocity, shape ``(2, n)``.
    """
    best, best_distance, limit, last = -1, np.inf, np.inf, 0
    for a in range(n_x):
        i = order[0, a]
        dx = samples[0, i] - wanted_x
        if dx * dx > limit:
            break
        for c in range(n_y):
            j = order[1, c]
            dy = samples[1, j] - wanted_y
            if dx * dx + dy * dy > limit:
                break
            blocked = False
            if n_cones > 0:
                blocked = in_cone(cones[last], samples[0, i], samples[1, j])
            k = 0
            while not blocked and k < n_cones:
                blocked = in_cone(cones[k], samples[0, i], samples[1, j])
                if blocked:
                    last = k
                k += 1
            if blocked:
                continue
            distance = np.hypot(dx, dy)
            place = i * n_y + j
            if distance < best_distance or (distance == best_distance and place < best):
                best, best_distance = place, distance
                limit = distance * distance * SLACK
    return best


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
