"""The nearest sample outside of all cones, found for many rows of samples at once.

A cone cuts a row of samples in one interval: each of its two edges changes its answer once along the row, rounding
included. Where, is worked out for several rows side by side; one exact question, to the sample nearest to that place,
settles it. The directions of the edges come from square roots at first. Where that is too close to call, the cone is
written anew as IR-SIM does it, from angles: so every answer is the one that IR-SIM's rounding gives.
"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.behaviors.velocity_obstacles import HRVO, SLACK, VO, disc_cone
from irsim_gym.jit import kernel

LANES = 16
"""So many rows are treated side by side: a loop of fixed length without branches becomes vector instructions."""

ROW_X, LOW, HIGH, BELOW, ABOVE, NEAREST = 0, LANES, 2 * LANES, 3 * LANES, 4 * LANES, 5 * LANES
"""Where the numbers of the rows begin: velocity along x, the samples that are taken, squared distances of free ones."""

ROW_NUMBERS = 6 * LANES

CLOSE = 1e-9
"""Nearer to an edge than this [m/s] a sample is asked again, of the exact cone; square roots err by less than 1e-12."""


@kernel
def rough_cones(
    mode: int, x: float, y: float, vx: float, vy: float, r: float, rounds: Floats, n_rounds: int, cones: Floats
) -> None:
    """Write the cones of discs without angles; arguments as for ``disc_cone``. Hybrid ones need angles."""
    for k in range(n_rounds):
        dx, dy, sum_r = rounds[k, 0] - x, rounds[k, 1] - y, r + rounds[k, 4]
        distance = np.sqrt(dy * dy + dx * dx)
        sine = sum_r / max(distance, sum_r)
        cosine = np.sqrt((1.0 - sine) * (1.0 + sine))
        ahead_x, ahead_y = dx / distance, dy / distance
        left_x, left_y = ahead_x * cosine - ahead_y * sine, ahead_y * cosine + ahead_x * sine
        right_x, right_y = ahead_x * cosine + ahead_y * sine, ahead_y * cosine - ahead_x * sine
        if mode == HRVO or left_x == 0.0 or right_x == 0.0 or not distance > 0.0:  # no cosine of an angle is 0
            disc_cone(mode, x, y, vx, vy, r, k, rounds, cones)
            continue
        apex_x, apex_y = rounds[k, 2], rounds[k, 3]
        if mode != VO:
            apex_x, apex_y = (vx + apex_x) / 2.0, (vy + apex_y) / 2.0
        cones[k, 0], cones[k, 1], cones[k, 2], cones[k, 3] = apex_x, apex_y, left_x, left_y
        cones[k, 4], cones[k, 5], cones[k, 6], cones[k, 7] = right_x, right_y, left_y / left_x, right_y / right_x
        cones[k, 8] = 0.0


@kernel
def cut_rows(c: int, first: float, step: float, count: int, cones: Floats, rows: Floats, spans: Floats) -> int:
    """Write which samples of each row cone c holds; return for how many rows that is in doubt.

    Args:
        c: The cone.
        first: Velocity along y of the first sample of a row [m/s].
        step: From one sample to the next [m/s].
        count: Number of samples in a row.
        cones: As ``write_cone`` writes them.
        rows: The rows: velocities along x from ROW_X on.
        spans: Written: number of the first sample in cone c, and of the first one behind it, shape
            ``(cone, 2 * LANES)``.
    """
    apex_x, apex_y, cos_left, sin_left = cones[c, 0], cones[c, 1], cones[c, 2], cones[c, 3]
    cos_right, sin_right, ratio_left, ratio_right = cones[c, 4], cones[c, 5], cones[c, 6], cones[c, 7]
    pitch, last, up, n_doubtful = 1.0 / step, float(count), apex_y - first, 0
    below_left, below_right = cos_left > 0.0, cos_right < 0.0  # what lies below the edge is in the cone
    for k in range(LANES):
        wx = rows[ROW_X + k] - apex_x
        at_left = np.floor((wx * ratio_left + up) * pitch + 0.5)
        at_right = np.floor((wx * ratio_right + up) * pitch + 0.5)
        at_left = at_left if at_left > -1.0 else -1.0
        at_left = at_left if at_left < last else last
        at_right = at_right if at_right > -1.0 else -1.0
        at_right = at_right if at_right < last else last
        gap_left = cos_left * ((first + at_left * step) - apex_y) - wx * sin_left
        gap_right = cos_right * ((first + at_right * step) - apex_y) - wx * sin_right
        end_left = at_left + 1.0 if (gap_left <= 0.0) == below_left else at_left
        end_right = at_right + 1.0 if (gap_right >= 0.0) == below_right else at_right
        low_left, high_left = -1.0 if below_left else end_left, end_left if below_left else last
        low_right, high_right = -1.0 if below_right else end_right, end_right if below_right else last
        low = low_left if low_left > low_right else low_right
        high = high_left if high_left < high_right else high_right
        spans[c, k], spans[c, LANES + k] = low if low < high else np.inf, high
        n_doubtful += int(np.abs(gap_left) <= CLOSE) | int(np.abs(gap_right) <= CLOSE)
    return n_doubtful


@kernel
def take(above: float, n_cones: int, spans: Floats, rows: Floats) -> None:
    """Write the connected samples about a place in each row that cones hold: from LOW on, up to HIGH without it.

    Args:
        above: Number of the sample above that place.
        n_cones: Number of cones.
        spans: As ``cut_rows`` writes it.
        rows: LOW and HIGH are written.
    """
    for k in range(LANES):
        rows[LOW + k], rows[HIGH + k] = above, above
    n_growing = 1
    while n_growing > 0:
        n_growing = 0
        for c in range(n_cones):
            for k in range(LANES):
                low, high, begin, end = rows[LOW + k], rows[HIGH + k], spans[c, k], spans[c, LANES + k]
                touches = (begin <= high) & (end >= low)
                is_lower, is_higher = touches & (begin < low), touches & (end > high)
                rows[LOW + k], rows[HIGH + k] = begin if is_lower else low, end if is_higher else high
                n_growing += int(is_lower) | int(is_higher)


@kernel
def measure_free(
    base: int, n_x: int, first: float, step: float, n_y: int, wanted_x: float, wanted_y: float, rows: Floats
) -> float:
    """Write how far the free samples next to those that are taken lie from the wanted velocity, squared, else inf.

    Returns:
        The smallest of these.
    """
    for k in range(LANES):
        is_row = base + k < n_x
        below, above, dx = rows[LOW + k] - 1.0, rows[HIGH + k], rows[ROW_X + k] - wanted_x
        dy_below, dy_above = (first + below * step) - wanted_y, (first + above * step) - wanted_y
        rows[BELOW + k] = dx * dx + dy_below * dy_below if is_row & (below >= 0.0) else np.inf
        rows[ABOVE + k] = dx * dx + dy_above * dy_above if is_row & (above < n_y) else np.inf
        rows[NEAREST + k] = rows[BELOW + k] if rows[BELOW + k] < rows[ABOVE + k] else rows[ABOVE + k]
    nearest2 = np.inf
    for k in range(LANES):
        nearest2 = rows[NEAREST + k] if rows[NEAREST + k] < nearest2 else nearest2
    return nearest2


@kernel
def first_not_below(wanted: float, first: float, step: float, count: int) -> int:
    """Return the number of the first of ascending samples that is not below a wanted velocity [m/s]."""
    k = int(min(max((wanted - first) / step, 0.0), float(count)))
    while k > 0 and first + (k - 1) * step >= wanted:
        k -= 1
    while k < count and first + k * step < wanted:
        k += 1
    return k


@kernel
def is_nearer(
    one: int,
    other: int,
    n_y: int,
    first_x: float,
    step_x: float,
    first_y: float,
    step_y: float,
    wanted_x: float,
    wanted_y: float,
) -> bool:
    """Return whether a sample is nearer to the wanted velocity than another one, if there is one; ties go by number."""
    if other < 0:
        return True
    gap = np.hypot((first_x + (one // n_y) * step_x) - wanted_x, (first_y + (one % n_y) * step_y) - wanted_y)
    best = np.hypot((first_x + (other // n_y) * step_x) - wanted_x, (first_y + (other % n_y) * step_y) - wanted_y)
    return bool(gap < best or (gap == best and one < other))


@kernel
def nearest_free(
    mode: int,
    x: float,
    y: float,
    vx: float,
    vy: float,
    r: float,
    rounds: Floats,
    n_rounds: int,
    cones: Floats,
    n_cones: int,
    first_x: float,
    step_x: float,
    n_x: int,
    first_y: float,
    step_y: float,
    n_y: int,
    wanted_x: float,
    wanted_y: float,
    spans: Floats,
    rows: Floats,
) -> int:
    """Return the sample outside of all cones that is nearest to the wanted velocity, -1 without any.

    Samples are numbered x-major; of several that are equally near the first counts. Rows are looked at from the wanted
    velocity outwards; in a row only the nearest free samples above and below it count.

    Args:
        mode: RVO, HRVO or VO.
        x: Position [m].
        y: Position [m].
        vx: Velocity [m/s].
        vy: Velocity [m/s].
        r: Radius [m].
        rounds: The discs, as ``disc_cone`` reads them.
        n_rounds: Number of discs.
        cones: The cones of the discs, which may be rough, and those of sides; shape ``(n, CONE)``.
        n_cones: Number of cones.
        first_x: First sample along x [m/s].
        step_x: From one to the next [m/s].
        n_x: Number of samples along x.
        first_y: As along x.
        step_y: As along x.
        n_y: As along x.
        wanted_x: Wanted velocity [m/s].
        wanted_y: Wanted velocity [m/s].
        spans: Scratch, shape ``(n, 2 * LANES)``.
        rows: Scratch, shape ``(ROW_NUMBERS,)``.
    """
    best, limit = -1, np.inf
    right, above = first_not_below(wanted_x, first_x, step_x, n_x), first_not_below(wanted_y, first_y, step_y, n_y)
    begin = max(min(right - LANES // 2, n_x - LANES), 0)
    base, end, gap = begin, begin, 0.0
    while gap < np.inf and gap * gap <= limit:
        for k in range(LANES):
            rows[ROW_X + k] = first_x + (base + k) * step_x
        for c in range(n_cones):
            if cut_rows(c, first_y, step_y, n_y, cones, rows, spans) > 0 and cones[c, 8] == 0.0:
                disc_cone(mode, x, y, vx, vy, r, c, rounds, cones)
                cut_rows(c, first_y, step_y, n_y, cones, rows, spans)
        take(float(above), n_cones, spans, rows)
        nearest2 = measure_free(base, n_x, first_y, step_y, n_y, wanted_x, wanted_y, rows)
        if nearest2 < np.inf and nearest2 <= limit:
            limit = min(limit, nearest2 * SLACK)
            for k in range(2 * LANES):
                if rows[BELOW + k] <= limit:
                    lane = k % LANES
                    j = int(rows[LOW + lane]) - 1 if k < LANES else int(rows[HIGH + lane])
                    place = (base + lane) * n_y + j
                    if is_nearer(place, best, n_y, first_x, step_x, first_y, step_y, wanted_x, wanted_y):
                        best = place
        begin, end = min(begin, base), max(end, base + LANES)
        to_left = wanted_x - (first_x + (begin - 1) * step_x) if begin > 0 else np.inf
        to_right = (first_x + end * step_x) - wanted_x if end < n_x else np.inf
        gap, base = (to_left, max(begin - LANES, 0)) if to_left < to_right else (to_right, end)
    return best
