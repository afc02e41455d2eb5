"""Clusters of neighbouring points of a scan, and the discs that fit them."""

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats, Rays, Records
from irsim_gym.base.kernels.structs import record_type
from irsim_gym.tasks.terms import kernel

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
ROUNDS = 3


@kernel
def join_beams(
    ranges: Rays, least: float, most: float, spacing: float, noise: float, closes: bool, joined: Flags
) -> None:
    """Write whether each beam hits the same surface as the one before it; the first one follows the last.

    Args:
        ranges: The scan [m], ``(n_beams,)``.
        least: Readings up to this are not valid [m].
        most: Readings from this on are no hits [m].
        spacing: Angle between neighbouring beams [rad].
        noise: Standard deviation of the readings [m].
        closes: Whether the beams go round a full circle.
        joined: Output, ``(2, n_beams)``; the second row is scratch memory.
    """
    n_beams, bend = ranges.shape[0], 2.0 * np.cos(spacing)
    flat, slack, step = joined[1], STRAIGHT + 2.0 * noise, 2.0 * LARGEST * spacing
    for i in range(n_beams):
        flat[i] = False
        if 0 < i < n_beams - 1 and ranges[i] < most and ranges[i - 1] < most and ranges[i + 1] < most:
            # Inverse ranges of points on a line are a sine of the angle.
            inner = 1.0 / ranges[i]
            off = 1.0 / ranges[i - 1] + 1.0 / ranges[i + 1] - bend * inner
            flat[i] = abs(off) <= 2.0 * slack * inner * inner
    for i in range(n_beams):
        near, far = min(ranges[i - 1], ranges[i]), max(ranges[i - 1], ranges[i])
        jump = max(far - near - 3.0 * noise, 0.0)
        is_straight = (flat[i - 1] and (flat[i - 2] or flat[i])) or (flat[i] and flat[(i + 1) % n_beams])
        is_close = jump * jump <= step * near or is_straight
        joined[0, i] = is_close and least < near and far < most and (i > 0 or closes)


@kernel
def find_clusters(
    ranges: Rays, least: float, most: float, size: float, joined: Flags, points: Floats, clusters: Records
) -> int:
    """Gather the points of the clusters that are not too wide, and return the number of clusters.

    Args:
        ranges: The scan [m], ``(n_beams,)``.
        least: Readings up to this are not valid [m].
        most: Readings from this on are no hits [m].
        size: Greatest extent along x and along y [m].
        joined: Whether each beam belongs to the same surface as the one before it, ``(2, n_beams)``.
        points: The ends of all beams [m], ``(2, 2, n_beams)``: in the second half those of clusters are written, one
            cluster after another.
        clusters: Output, ``(n_beams,)``.
    """
    n_beams, start, count, n_points = ranges.shape[0], 0, 0, 0
    while start < n_beams - 1 and joined[0, start]:
        start += 1
    ends, kept, k = points[0], points[1], 0
    while k < n_beams:
        i = (start + k) % n_beams
        if not least < ranges[i] < most:
            k += 1
            continue
        first, left, right, low, high = n_points, ends[0, i], ends[0, i], ends[1, i], ends[1, i]
        while True:
            kept[0, n_points], kept[1, n_points] = ends[0, i], ends[1, i]
            left, right = min(left, ends[0, i]), max(right, ends[0, i])
            low, high = min(low, ends[1, i]), max(high, ends[1, i])
            n_points, k, i = n_points + 1, k + 1, (i + 1) % n_beams
            if k >= n_beams or not joined[0, i]:
                break
        if max(right - left, high - low) > size:
            n_points = first
            continue
        one = clusters[count]
        one.x, one.y, one.first, one.last, one.track = 0.5 * (left + right), 0.5 * (low + high), first, n_points, -1
        count += 1
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
    doubt = noise + misfit / n
    return cx, cy, r, min(left * doubt / noise, spread) + DRIFT, doubt
