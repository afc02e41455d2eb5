"""Two-dimensional linear programs in a disc: the permitted velocity nearest to a preferred one.

Each half-plane permits the velocities on one side of a line. They are added one after another. If one cuts off the
optimum so far, the new optimum lies on its border (de Berg et al., Computational Geometry, chapter 4; van den Berg et
al. 2011, section 5).
"""

import numpy as np

from irsim_gym.base.arraytypes import Record, Records, Vector
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import record_type

HALF_PLANE = record_type("nx ny least")
"""A half-plane with the unit normal n: it permits the vectors v with n . v >= least."""

PARALLEL = 1e-9
SLACK = 1e-12


@kernel
def set_plane(plane: Record, nx: float, ny: float, least: float) -> None:
    """Write a half-plane."""
    plane.nx, plane.ny, plane.least = nx, ny, least


@kernel
def choose(
    planes: Records, n_hard: int, count: int, limit: float, wanted_x: float, wanted_y: float, spare: Records
) -> Vector:
    """Return the vector nearest to a preferred one that satisfies all half-planes and is no longer than ``limit``.

    If there is none, the hard half-planes are satisfied, and the largest violation of the others is minimal.

    Args:
        planes: Half-planes, records of type ``HALF_PLANE``.
        n_hard: Number of hard half-planes, which come first.
        count: Number of half-planes.
        limit: Greatest length [m/s].
        wanted_x: The preferred vector [m/s].
        wanted_y: The preferred vector [m/s].
        spare: Scratch, as many half-planes.
    """
    x, y, failed = solve(planes, count, limit, wanted_x, wanted_y, False)
    if failed < count:
        x, y = least_violation(planes, n_hard, count, failed, limit, x, y, spare)
    return x, y


@kernel
def solve(planes: Records, count: int, limit: float, x: float, y: float, farthest: bool) -> tuple[float, float, int]:
    """Return the permitted vector nearest to (x, y), and ``count``; or the last optimum and the row that left none.

    With ``farthest``, (x, y) is a unit vector, and what is asked for goes farthest in its direction.
    """
    best_x, best_y = limit * x, limit * y
    if not farthest:
        length = np.sqrt(x * x + y * y)
        scale = limit / length if length > limit else 1.0
        best_x, best_y = scale * x, scale * y
    for i in range(count):
        if planes[i].nx * best_x + planes[i].ny * best_y < planes[i].least:
            # A half-plane that cuts off the optimum so far: the new optimum lies on its border.
            next_x, next_y, feasible = best_on_border(planes, i, limit, x, y, farthest)
            if not feasible:
                return best_x, best_y, i
            best_x, best_y = next_x, next_y
    return best_x, best_y, count


@kernel
def best_on_border(
    planes: Records, i: int, limit: float, x: float, y: float, farthest: bool
) -> tuple[float, float, bool]:
    """Return the optimum on the border of half-plane i that those before it permit, and whether there is one.

    A point of the border is ``least * normal + t * along``, so the disc and each half-plane bound t.
    """
    nx, ny, least = planes[i].nx, planes[i].ny, planes[i].least
    along_x, along_y = ny, -nx
    # The border is ``least`` away from the origin, so the disc cuts it to -sqrt(half2) <= t <= sqrt(half2).
    half2 = limit * limit - least * least
    if half2 < 0.0:
        return 0.0, 0.0, False
    high = np.sqrt(half2)
    low = -high
    for j in range(i):
        other = planes[j]
        # On the border, the other half-plane demands gain * t >= missing: a bound of t from below or above, by gain's
        # sign.
        gain = other.nx * along_x + other.ny * along_y
        missing = other.least - least * (other.nx * nx + other.ny * ny)
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
    planes: Records, n_hard: int, count: int, first: int, limit: float, x: float, y: float, spare: Records
) -> Vector:
    """Return the vector with the smallest largest violation of the soft half-planes, within the hard ones.

    If a half-plane is violated more than all before it, the new optimum violates it at least as much as any of them.
    Points at which two half-planes are violated equally form a line, so this is another linear program in the plane.

    Args:
        planes: Half-planes, records of type ``HALF_PLANE``.
        n_hard: The first so many are hard.
        count: Number of half-planes.
        first: The first half-plane that (x, y) may violate.
        limit: Greatest length [m/s].
        x: Optimum of the half-planes before ``first`` [m/s].
        y: Optimum of the half-planes before ``first`` [m/s].
        spare: Scratch, as many half-planes.
    """
    worst = 0.0
    for i in range(first, count):
        nx, ny, least = planes[i].nx, planes[i].ny, planes[i].least
        if least - (nx * x + ny * y) <= worst:
            continue
        # Hard half-planes stay as they are. For each soft one before i, the new one permits the points where its
        # violation is no larger than that of i; then go as far as possible along i's normal.
        for j in range(n_hard):
            set_plane(spare[j], planes[j].nx, planes[j].ny, planes[j].least)
        k = n_hard
        for j in range(n_hard, i):
            dx, dy = planes[j].nx - nx, planes[j].ny - ny
            length = np.sqrt(dx * dx + dy * dy)
            # With equal normals, the difference of both violations is the same everywhere: nothing to choose.
            if length > PARALLEL:
                set_plane(spare[k], dx / length, dy / length, (planes[j].least - least) / length)
                k += 1
        next_x, next_y, failed = solve(spare, k, limit, nx, ny, True)
        # If rounding leaves no optimum, the former one is kept, which is close to it.
        if failed == k:
            x, y = next_x, next_y
        worst = least - (nx * x + ny * y)
    return x, y
