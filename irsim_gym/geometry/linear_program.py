"""Two-dimensional linear programs within a disc: the velocity nearest to a wanted one that half-planes permit.

A half-plane is a row (normal x, normal y, least) with a unit normal: it permits the vectors v with normal . v >= least.
The half-planes are taken in one after another; where one cuts off the optimum so far, the new optimum lies on its
border (de Berg et al., Computational Geometry, chapter 4; van den Berg et al. 2011, section 5).
"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.jit import kernel

PARALLEL = 1e-9
SLACK = 1e-12


@kernel
def choose(
    planes: Floats, n_hard: int, count: int, limit: float, wanted_x: float, wanted_y: float, spare: Floats
) -> tuple[float, float]:
    """Return the vector nearest to a wanted one that all half-planes permit, no longer than ``limit``.

    Where there is none, the hard half-planes hold and the worst violation of the others is as small as can be.

    Args:
        planes: Half-planes, shape ``(n, 3)``.
        n_hard: The first so many are hard.
        count: Number of half-planes.
        limit: Greatest length [m/s].
        wanted_x: The wanted vector [m/s].
        wanted_y: The wanted vector [m/s].
        spare: Scratch, shape ``(n, 3)``.
    """
    x, y, failed = solve(planes, count, limit, wanted_x, wanted_y, False)
    if failed < count:
        x, y = least_violation(planes, n_hard, count, failed, limit, x, y, spare)
    return x, y


@kernel
def solve(planes: Floats, count: int, limit: float, x: float, y: float, farthest: bool) -> tuple[float, float, int]:
    """Return the permitted vector nearest to (x, y), and ``count``; or the last optimum and the row that left none.

    With ``farthest``, (x, y) is a unit vector, and what is asked for goes farthest in its direction.
    """
    best_x, best_y = limit * x, limit * y
    if not farthest:
        length = np.sqrt(x * x + y * y)
        scale = limit / length if length > limit else 1.0
        best_x, best_y = scale * x, scale * y
    for i in range(count):
        if planes[i, 0] * best_x + planes[i, 1] * best_y < planes[i, 2]:
            next_x, next_y, found = best_on_border(planes, i, limit, x, y, farthest)
            if not found:
                return best_x, best_y, i
            best_x, best_y = next_x, next_y
    return best_x, best_y, count


@kernel
def best_on_border(
    planes: Floats, i: int, limit: float, x: float, y: float, farthest: bool
) -> tuple[float, float, bool]:
    """Return the optimum on the border of half-plane i that those before it permit, and whether there is one.

    A point of the border is ``least * normal + t * along``, so the disc and each half-plane bound t.
    """
    nx, ny, least = planes[i, 0], planes[i, 1], planes[i, 2]
    along_x, along_y = ny, -nx
    half2 = limit * limit - least * least
    if half2 < 0.0:
        return 0.0, 0.0, False
    high = np.sqrt(half2)
    low = -high
    for j in range(i):
        gain = planes[j, 0] * along_x + planes[j, 1] * along_y
        missing = planes[j, 2] - least * (planes[j, 0] * nx + planes[j, 1] * ny)
        if np.abs(gain) <= PARALLEL:
            if missing > SLACK:
                return 0.0, 0.0, False
        elif gain > 0.0:
            low = max(low, missing / gain)
        else:
            high = min(high, missing / gain)
        if low > high + SLACK:
            return 0.0, 0.0, False
    t = x * along_x + y * along_y
    t = (high if t > 0.0 else low) if farthest else min(max(t, low), high)
    return least * nx + t * along_x, least * ny + t * along_y, True


@kernel
def least_violation(
    planes: Floats, n_hard: int, count: int, first: int, limit: float, x: float, y: float, spare: Floats
) -> tuple[float, float]:
    """Return the vector whose worst violation of the soft half-planes is least, within the hard ones.

    A half-plane that is violated more than any before it carries the new optimum: there it is violated as much as at
    most one other, and where both are violated alike is a line again. That is a linear program in the plane.

    Args:
        planes: Half-planes, shape ``(n, 3)``.
        n_hard: The first so many are hard.
        count: Number of half-planes.
        first: The first half-plane that (x, y) may violate.
        limit: Greatest length [m/s].
        x: Optimum of the half-planes before ``first`` [m/s].
        y: Optimum of the half-planes before ``first`` [m/s].
        spare: Scratch, shape ``(n, 3)``.
    """
    worst = 0.0
    for i in range(first, count):
        nx, ny, least = planes[i, 0], planes[i, 1], planes[i, 2]
        if least - (nx * x + ny * y) <= worst:
            continue
        for j in range(n_hard):
            spare[j, 0], spare[j, 1], spare[j, 2] = planes[j, 0], planes[j, 1], planes[j, 2]
        k = n_hard
        for j in range(n_hard, i):
            dx, dy = planes[j, 0] - nx, planes[j, 1] - ny
            length = np.sqrt(dx * dx + dy * dy)
            if length > PARALLEL:
                spare[k, 0], spare[k, 1], spare[k, 2] = dx / length, dy / length, (planes[j, 2] - least) / length
                k += 1
        next_x, next_y, failed = solve(spare, k, limit, nx, ny, True)
        if failed == k:
            x, y = next_x, next_y
        worst = least - (nx * x + ny * y)
    return x, y
