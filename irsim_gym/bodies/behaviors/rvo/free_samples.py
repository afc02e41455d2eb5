"""Finds the nearest sample outside of all cones, for many rows of samples at once.

A cone cuts a row of samples in one interval: the test of each of its two edges changes once along the row, even with
rounding. The place of the change is computed for several rows at once; one exact test of the sample nearest to that
place decides. The directions of the edges first come from square roots. If the result is too close to decide, the cone
is recomputed from angles as in IR-SIM, so that all results agree with IR-SIM's rounding.
"""

from dataclasses import dataclass

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Record, Records
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import Struct, record_type
from irsim_gym.bodies.behaviors.rvo.velocity_obstacles import HRVO, SLACK, VO, Axis, disc_cone, set_cone
from irsim_gym.bodies.behaviors.shared.surroundings import Ego, Surroundings

LANES = 16
"""Number of rows per pass: the compiler turns a loop of fixed length without branches into vector instructions."""

ROWS = record_type("x low high below above nearest", LANES)
"""LANES rows: velocity along x [m/s]; the interval of samples that are taken, from number ``low`` to before ``high``;
squared distance of the free samples below and above it from the wanted velocity, and the smaller of both [m2/s2].
"""

SPAN = record_type("low high", LANES)
"""Number of the first sample of each row in a cone (inf for none), and of the first one after it."""

CLOSE = 1e-9
"""Samples nearer to an edge than this [m/s] are tested again with the exact cone; square roots err by less than 1e-12.
"""


@dataclass
class RvoTables(Struct):
    """Scratch memory of one shard: what one body sees, and the velocities that it tries.

    Attributes:
        seen: What the body sees.
        cones: Forbidden velocities, records of type ``CONE``: of all discs, then of walls.
        spans: The cuts of each cone with rows of samples, records of type ``SPAN``.
        rows: A record of type ``ROWS``, shape ``(1,)``.
        samples: The velocities to try along x and y [m/s], ascending, shape ``(2, n_samples)``.
        order: Their indices by distance from the wanted velocity, shape ``(2, n_samples)``.
    """

    seen: Surroundings
    cones: Records
    spans: Records
    rows: Records
    samples: Floats
    order: Ints


@kernel
def rough_cones(mode: int, ego: Ego, rounds: Records, cones: Records) -> None:
    """Write the cones of discs without angles; arguments as for ``disc_cones``. Hybrid ones need angles."""
    for k in range(rounds.shape[0]):
        disc, cone = rounds[k], cones[k]
        dx, dy, sum_r = disc.x - ego.x, disc.y - ego.y, ego.radius + disc.radius
        distance = np.sqrt(dy * dy + dx * dx)
        # The half angle of the cone; a body that overlaps the disc is as if it touched it (90 degrees).
        sine = sum_r / max(distance, sum_r)
        cosine = np.sqrt((1.0 - sine) * (1.0 + sine))
        ahead_x, ahead_y = dx / distance, dy / distance
        # The direction of the disc, turned by the half angle to either side.
        left_x, left_y = ahead_x * cosine - ahead_y * sine, ahead_y * cosine + ahead_x * sine
        right_x, right_y = ahead_x * cosine + ahead_y * sine, ahead_y * cosine - ahead_x * sine
        # Exact edges are never vertical, as no float64 has the cosine 0; rough ones may be, without a finite slope.
        if mode == HRVO or left_x == 0.0 or right_x == 0.0 or not distance > 0.0:
            disc_cone(mode, ego, disc, cone)
            continue
        # The apex is the other body's velocity (VO), or the mean of both (RVO, van den Berg et al. 2008).
        apex_x, apex_y = disc.vx, disc.vy
        if mode != VO:
            apex_x, apex_y = (ego.vx + apex_x) / 2.0, (ego.vy + apex_y) / 2.0
        set_cone(cone, apex_x, apex_y, left_x, left_y, right_x, right_y)


@kernel
def cut_rows(cone: Record, axis: Axis, rows: Record, span: Record) -> int:
    """Write which samples of each row a cone holds; return the number of rows for which this is doubtful.

    Args:
        cone: The cone.
        axis: The samples of each row, which lie along y.
        rows: The rows.
        span: Written.
    """
    apex_x, apex_y, cos_left, sin_left = cone.apex_x, cone.apex_y, cone.left_x, cone.left_y
    cos_right, sin_right, ratio_left, ratio_right = cone.right_x, cone.right_y, cone.left_slope, cone.right_slope
    first, step, last = axis.first, axis.step, float(axis.n)
    # Slopes turn the offset wx from the apex into the height at which an edge crosses the row.
    pitch, up, n_doubtful = 1.0 / step, apex_y - first, 0
    # Which side of an edge the cone is on, along a row: True if the samples below the edge are in the cone.
    below_left, below_right = cos_left > 0.0, cos_right < 0.0
    for k in range(LANES):
        wx = rows.x[k] - apex_x
        # The sample nearest to the crossing; -1 and n stand for beyond the ends of the row.
        at_left = np.floor((wx * ratio_left + up) * pitch + 0.5)
        at_right = np.floor((wx * ratio_right + up) * pitch + 0.5)
        at_left = at_left if at_left > -1.0 else -1.0
        at_left = at_left if at_left < last else last
        at_right = at_right if at_right > -1.0 else -1.0
        at_right = at_right if at_right < last else last
        # Cross products with the edges' directions: in the cone, gap_left <= 0 and gap_right >= 0, edges included.
        gap_left = cos_left * ((first + at_left * step) - apex_y) - wx * sin_left
        gap_right = cos_right * ((first + at_right * step) - apex_y) - wx * sin_right
        # The first sample above the change: the sample itself, or the next if it is still on the lower side.
        end_left = at_left + 1.0 if (gap_left <= 0.0) == below_left else at_left
        end_right = at_right + 1.0 if (gap_right >= 0.0) == below_right else at_right
        # Each edge leaves a half-line of samples, [low, high); the cone is what both have in common.
        low_left, high_left = -1.0 if below_left else end_left, end_left if below_left else last
        low_right, high_right = -1.0 if below_right else end_right, end_right if below_right else last
        low = low_left if low_left > low_right else low_right
        high = high_left if high_left < high_right else high_right
        span.low[k], span.high[k] = low if low < high else np.inf, high
        # Testing these samples is enough: all others of the row are farther from the edge.
        n_doubtful += int(np.abs(gap_left) <= CLOSE) | int(np.abs(gap_right) <= CLOSE)
    return n_doubtful


@kernel
def take(above: float, n_cones: int, spans: Records, rows: Record) -> None:
    """Write for each row the interval of samples in cones that holds or touches a place.

    Writes: rows.

    Args:
        above: Number of the sample above that place.
        n_cones: Number of cones.
        spans: As ``cut_rows`` writes them.
        rows: ``low`` and ``high`` are written.
    """
    for k in range(LANES):
        rows.low[k], rows.high[k] = above, above
    # Spans that touch or overlap merge until none is added; adjacent samples leave no free one between them.
    n_growing = 1
    while n_growing > 0:
        n_growing = 0
        for c in range(n_cones):
            for k in range(LANES):
                low, high, begin, end = rows.low[k], rows.high[k], spans[c].low[k], spans[c].high[k]
                touches = (begin <= high) & (end >= low)
                is_lower, is_higher = touches & (begin < low), touches & (end > high)
                # Selections in place of branches, so that all lanes take one path.
                rows.low[k], rows.high[k] = begin if is_lower else low, end if is_higher else high
                n_growing += int(is_lower) | int(is_higher)


@kernel
def measure_free(base: int, along_x: Axis, along_y: Axis, rows: Record) -> float:
    """Write the squared distances of the free samples beside the taken ones from the wanted velocity; inf for none.

    Returns:
        The smallest of these.
    """
    first, step = along_y.first, along_y.step
    for k in range(LANES):
        # The last block may reach beyond the last row.
        is_row = base + k < along_x.n
        below, above, dx = rows.low[k] - 1.0, rows.high[k], rows.x[k] - along_x.wanted
        dy_below, dy_above = (first + below * step) - along_y.wanted, (first + above * step) - along_y.wanted
        rows.below[k] = dx * dx + dy_below * dy_below if is_row & (below >= 0.0) else np.inf
        rows.above[k] = dx * dx + dy_above * dy_above if is_row & (above < along_y.n) else np.inf
        rows.nearest[k] = rows.below[k] if rows.below[k] < rows.above[k] else rows.above[k]
    # A reduction of its own: the loop above stays free of dependences between lanes.
    nearest2 = np.inf
    for k in range(LANES):
        nearest2 = rows.nearest[k] if rows.nearest[k] < nearest2 else nearest2
    return nearest2


@kernel
def first_not_below(axis: Axis) -> int:
    """Return the number of the first of the samples along an axis that is not below the wanted velocity."""
    first, step = axis.first, axis.step
    k = int(min(max((axis.wanted - axis.first) / axis.step, 0.0), float(axis.n)))
    # Rounding may put the quotient one off; the samples themselves decide.
    while k > 0 and first + (k - 1) * step >= axis.wanted:
        k -= 1
    while k < axis.n and first + k * step < axis.wanted:
        k += 1
    return k


@kernel
def gap_of(place: int, along_x: Axis, along_y: Axis) -> float:
    """Return how far a sample lies from the wanted velocity [m/s]."""
    i, j = place // along_y.n, place % along_y.n
    return float(
        np.hypot(
            (along_x.first + i * along_x.step) - along_x.wanted, (along_y.first + j * along_y.step) - along_y.wanted
        )
    )


@kernel
def is_nearer(first: int, other: int, along_x: Axis, along_y: Axis) -> bool:
    """Return whether a sample is nearer to the wanted velocity than another one, if there is one; ties go by number."""
    if other < 0:
        return True
    gap, best = gap_of(first, along_x, along_y), gap_of(other, along_x, along_y)
    return bool(gap < best or (gap == best and first < other))


@kernel
def nearest_free(mode: int, ego: Ego, n_cones: int, along_x: Axis, along_y: Axis, tables: RvoTables) -> int:
    """Return the sample outside of all cones that is nearest to the wanted velocity, -1 without any.

    Samples are numbered x-major; of several that are equally near the first counts. Rows are looked at from the wanted
    velocity outwards; in a row only the nearest free samples above and below it count.

    Reads: tables (cones, rows, seen).
    Writes: tables (cones, rows, seen, spans).

    Args:
        mode: RVO, HRVO or VO.
        ego: The body that decides.
        n_cones: Number of cones; those of discs may be rough.
        along_x: The samples along x.
        along_y: The samples along y.
        tables: What the body sees, and its cones.
    """
    rounds, cones, spans, rows = tables.seen.rounds, tables.cones, tables.spans, tables.rows[0]
    first_x, step_x, n_x, wanted_x = along_x
    best, limit = -1, np.inf
    right, above = first_not_below(along_x), first_not_below(along_y)
    # A block of rows with the wanted velocity in its middle, as far as there are rows to both sides.
    begin = max(min(right - LANES // 2, n_x - LANES), 0)
    base, end, gap = begin, begin, 0.0
    # No row beyond `gap` can hold a sample nearer than the best one so far.
    while gap < np.inf and gap * gap <= limit:
        for k in range(LANES):
            rows.x[k] = first_x + (base + k) * step_x
        for c in range(n_cones):
            # A sample close to an edge of a rough cone: the cone is computed exactly, once, and cut again.
            if cut_rows(cones[c], along_y, rows, spans[c]) > 0 and cones[c].is_exact == 0:
                disc_cone(mode, ego, rounds[c], cones[c])
                cut_rows(cones[c], along_y, rows, spans[c])
        take(float(above), n_cones, spans, rows)
        nearest2 = measure_free(base, along_x, along_y, rows)
        if nearest2 < np.inf and nearest2 <= limit:
            # Squares only preselect: `is_nearer` compares distances as IR-SIM rounds them, and breaks ties by number.
            limit = min(limit, nearest2 * SLACK)
            for k in range(LANES):
                place = (base + k) * along_y.n
                # The free samples just below and just above the taken interval [low, high).
                below, behind = place + int(rows.low[k]) - 1, place + int(rows.high[k])
                if rows.below[k] <= limit and is_nearer(below, best, along_x, along_y):
                    best = below
                if rows.above[k] <= limit and is_nearer(behind, best, along_x, along_y):
                    best = behind
        # Rows begin to end are done. The next block is on the side whose nearest row is closer to the wanted velocity.
        begin, end = min(begin, base), max(end, base + LANES)
        to_left = wanted_x - (first_x + (begin - 1) * step_x) if begin > 0 else np.inf
        to_right = (first_x + end * step_x) - wanted_x if end < n_x else np.inf
        gap, base = (to_left, max(begin - LANES, 0)) if to_left < to_right else (to_right, end)
    return best
