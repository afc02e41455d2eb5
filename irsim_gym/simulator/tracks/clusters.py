"""Clusters of neighbouring points of a scan, and the discs that fit them."""

import numpy as np

from irsim_gym.base.arraytypes import Floats, Rays, Records
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import record_type

CLUSTER = record_type("x y", first=np.int64, last=np.int64, track=np.int64)
"""The middle of a cluster [m], its first point and one past its last, and the track that it belongs to, or -1."""

LARGEST = 0.35
"""Neighbouring points of a disc of up to this radius [m] are joined wherever they are on it."""
STRAIGHT = 0.02
"""Four points in a row are joined, however far apart, if the inner ones are this near to a line [m]."""
ANCHOR = 1.0 / 0.3**2
"""Weight of the expected centre [1/m2]: it decides only what a cluster of one or two points leaves open."""
SMALLEST, WIDEST = 0.05, 0.6
"""Bounds of the radius of a disc [m]."""
DRIFT = 0.005**2
"""How much the variance of a radius grows with each scan [m2]: points of two bodies may have been fitted as one."""
ROUNDS, NEAR_ENOUGH = 3, 1e-4**2
"""Most rounds of a fit, and the square of a step after which there is no further one [m2]."""


@kernel
def join_beams(ranges: Rays, limits: Rays, spacing: float, noise: float, closes: bool, joined: Rays) -> None:
    """Write whether each beam hits the same surface as the one before it; the loops are vectorised.

    Args:
        ranges: The scan [m], ``(n_beams,)``.
        limits: Valid readings lie between these two [m].
        spacing: Angle between neighbouring beams [rad].
        noise: Standard deviation of the readings [m].
        closes: Whether the beams go round a full circle, so that the first one follows the last.
        joined: Output, 1 or 0, ``(3, n_beams)``; the other rows are scratch memory.
    """
    n, least, most = ranges.shape[0], limits[0], limits[1]
    yes, no, bend = np.float32(1.0), np.float32(0.0), np.float32(2.0 * np.cos(spacing))
    slack, step = np.float32(2.0 * STRAIGHT + 4.0 * noise), np.float32(2.0 * LARGEST * spacing)
    inverse, flat, same, blur = joined[1], joined[2], joined[0], np.float32(3.0 * noise)
    for i in range(n):
        inverse[i] = yes / ranges[i] if (least < ranges[i]) & (ranges[i] < most) else no
        flat[i] = no
    if n < 4:
        same[:] = no
        return
    line_up(inverse[: n - 2], inverse[1 : n - 1], inverse[2:], bend, slack, flat[1 : n - 1])
    join_near(ranges[: n - 1], ranges[1:], inverse[: n - 1], inverse[1:], step, blur, same[1:])
    join_near(ranges[n - 1 :], ranges[:1], inverse[n - 1 :], inverse[:1], step, blur, same[:1])
    join_straight(flat[: n - 3], flat[1 : n - 2], flat[2 : n - 1], flat[3:], same[2 : n - 1])
    if not closes:
        same[0] = no


@kernel
def line_up(before: Rays, now: Rays, after: Rays, bend: np.float32, slack: np.float32, flat: Rays) -> None:
    """Write 1 where three neighbouring points are on a line, else 0: inverse ranges on one are a sine of the angle."""
    yes, no = np.float32(1.0), np.float32(0.0)
    for i in range(flat.shape[0]):
        off = abs(before[i] + after[i] - bend * now[i])
        is_straight = (off <= slack * now[i] * now[i]) & (before[i] > no) & (after[i] > no)
        flat[i] = yes if is_straight else no


@kernel
def join_near(
    one: Rays, other: Rays, seen: Rays, other_seen: Rays, step: np.float32, blur: np.float32, same: Rays
) -> None:
    """Write 1 where two neighbouring readings are near enough, and both valid, else 0."""
    yes, no = np.float32(1.0), np.float32(0.0)
    for i in range(same.shape[0]):
        jump = max(abs(other[i] - one[i]) - blur, no)
        is_near = (jump * jump <= step * min(one[i], other[i])) & (seen[i] * other_seen[i] > no)
        same[i] = yes if is_near else no


@kernel
def join_straight(flat: Rays, before: Rays, now: Rays, after: Rays, same: Rays) -> None:
    """Write 1 where a beam's point is on a line with three others next to it."""
    for i in range(same.shape[0]):
        same[i] = max(same[i], max(before[i] * max(flat[i], now[i]), now[i] * after[i]))


@kernel
def flag_gaps(three: Rays, two: Rays, one: Rays, now: Rays, ends: Rays) -> None:
    """Write 1 for each hit behind one or two beams without, else 0, from inverse ranges up to three beams before."""
    for i in range(now.shape[0]):
        ends[i] = np.float32((now[i] > 0.0) & (one[i] == 0.0) & (two[i] + three[i] > 0.0))


@kernel
def mend(ranges: Rays, spacing: float, noise: float, joined: Rays) -> None:
    """Bridge gaps of one or two beams without a valid reading between two hits: they were lost.

    A lost beam gets minus the nearer hit as its reading, which shows neither a point nor free space. Hits that may be
    on one disc are joined. Edges that recede on both sides are those of two bodies, and what is between them is free.

    Args:
        ranges: The scan [m], ``(n_beams,)``; lost beams are written.
        spacing: Angle between neighbouring beams [rad].
        noise: Standard deviation of the readings [m].
        joined: As ``join_beams`` leaves it, ``(3, n_beams)``; the first row is written.
    """
    n, step, same, inverse, ends = ranges.shape[0], 2.0 * LARGEST * spacing, joined[0], joined[1], joined[2]
    if n < 4:
        return
    flag_gaps(inverse[: n - 3], inverse[1 : n - 2], inverse[2 : n - 1], inverse[3:], ends)
    for i in range(3, n):
        if ends[i - 3] == 0.0:
            continue
        last = i - 2 if inverse[i - 2] > 0.0 else i - 3
        one, other, ahead, behind = ranges[last], ranges[i], last - 1 if last > 0 else n - 1, i + 1 if i < n - 1 else 0
        recede = one - ranges[ahead] > ranges[behind] - other + 4.0 * noise
        if inverse[ahead] == 0.0 or inverse[behind] == 0.0 or not recede:
            is_near = (other - one) * (other - one) <= step * (i - last) * min(one, other)
            for k in range(last + 1, i):
                ranges[k], same[k] = -min(one, other), np.float32(is_near)
            same[i] = np.float32(is_near)


@kernel
def find_clusters(size: float, joined: Rays, points: Floats, clusters: Records) -> int:
    """Gather the points of the clusters that are not too wide, and return the number of clusters.

    Writes: points.

    Args:
        size: Greatest extent along x and along y [m].
        joined: 1 for each beam that hits the same surface as the one before it; inverse readings, 0 for beams that
            hit nothing or were lost; ``(3, n_beams)``.
        points: The ends of all beams [m], ``(2, 2, n_beams)``: in the second half those of clusters are written, one
            cluster after another.
        clusters: Output, ``(n_beams,)``.
    """
    n_beams, start, count, n_points, k = joined.shape[1], 0, 0, 0, 0
    while start < n_beams - 1 and joined[0, start] > 0.0:
        start += 1
    x, y, kept_x, kept_y = points[0, 0], points[0, 1], points[1, 0], points[1, 1]
    same, hits = joined[0], joined[1]
    while k < n_beams:
        first = start + k - (n_beams if start + k >= n_beams else 0)
        if hits[first] == 0.0:
            k += 1
            continue
        last, length = first, 1
        while k + length < n_beams:
            after = last + 1 if last < n_beams - 1 else 0
            if same[after] == 0.0:
                break
            last, length = after, length + 1
        k += length
        if max(abs(x[first] - x[last]), abs(y[first] - y[last])) > size:
            continue
        left, right, low, high, i, j = x[first], x[first], y[first], y[first], first, n_points
        for _ in range(length):
            if hits[i] > 0.0:
                kept_x[j], kept_y[j], j = x[i], y[i], j + 1
                left, right, low, high = min(left, x[i]), max(right, x[i]), min(low, y[i]), max(high, y[i])
            i = i + 1 if i < n_beams - 1 else 0
        if max(right - left, high - low) <= size:
            cluster = clusters[count]
            cluster.x, cluster.y, cluster.track = 0.5 * (left + right), 0.5 * (low + high), -1
            cluster.first, cluster.last = n_points, j
            n_points, count = j, count + 1
    return count


@kernel
def fit_disc(
    points: Floats, x: float, y: float, radius: float, spread: float, noise: float
) -> tuple[float, float, float, float, float]:
    """Return centre and radius of the disc whose edge is nearest to some points, and how sure they are.

    Args:
        points: The points [m], ``(2, n)``.
        x: Where the centre is expected [m].
        y: As ``x``.
        radius: What the radius is expected to be [m].
        spread: Variance of that radius [m2].
        noise: Variance of the points [m2].

    Returns:
        x, y and radius [m], the variance of the radius and that of each coordinate of the centre [m2].
    """
    cx, cy, r, misfit, n = x, y, radius, 0.0, points.shape[1]
    weight, left = 1.0 / noise, 0.0
    for _ in range(ROUNDS):
        # Normal equations of |c - p| = r for centre and radius; the radius is eliminated first.
        xx, xy, yy, gx, gy = ANCHOR, 0.0, ANCHOR, ANCHOR * (cx - x), ANCHOR * (cy - y)
        bx, by, rr, gr, misfit = 0.0, 0.0, 1.0 / spread, (r - radius) / spread, 0.0
        for i in range(n):
            dx, dy = cx - points[0, i], cy - points[1, i]
            away = max(np.sqrt(dx * dx + dy * dy), 1e-9)
            ux, uy, off = dx / away, dy / away, away - r
            xx, xy, yy = xx + weight * ux * ux, xy + weight * ux * uy, yy + weight * uy * uy
            bx, by, rr = bx - weight * ux, by - weight * uy, rr + weight
            gx, gy, gr, misfit = gx + weight * ux * off, gy + weight * uy * off, gr - weight * off, misfit + off * off
        xx, xy, yy = xx - bx * bx / rr, xy - bx * by / rr, yy - by * by / rr
        hx, hy, whole = gx - bx * gr / rr, gy - by * gr / rr, xx * yy - xy * xy
        sx, sy = (yy * hx - xy * hy) / whole, (xx * hy - xy * hx) / whole
        cx, cy = cx - sx, cy - sy
        r = min(max(r - (gr - bx * sx - by * sy) / rr, SMALLEST), WIDEST)
        left = 1.0 / rr + (bx * bx * yy - 2.0 * bx * by * xy + by * by * xx) / (whole * rr * rr)
        if sx * sx + sy * sy < NEAR_ENOUGH:
            break
    doubt = noise + misfit / n
    return cx, cy, r, min(left * doubt / noise, spread) + DRIFT, doubt
