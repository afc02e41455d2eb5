"""Many segments and discs at once, made ready for the loops over beams, and these loops.

What ``geometry/rays.py`` does for one primitive is split here: first all primitives of a chunk are looked at in lanes
(which of them can be seen, the coefficients of their inverse depth, which beams may meet them), then each one that is
kept is cast against the beams of its span alone. All tables are flat with a stride of ``CHUNK``: constant offsets into
one array let the compiler see that its parts do not overlap.

On the line through a and b the inverse depth of a beam with unit direction d is n.d with n = (by - ay, ax - bx) / (a x
b); with m = a + b, the place on the segment, from -1 at a to 1 at b, is (q.d) / (n.d) with q = (-my, mx) / (a x b). So
a beam meets the segment where abs(q.d) <= n.d: two dot products, an absolute value and a comparison.
"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Floats, Rays, Spans
from irsim_gym.geometry.rays import EDGE_ON
from irsim_gym.jit import kernel

Eye = tuple[float, float, float, float]

CHUNK = 64
"""Primitives that are looked at together."""

BLOCK = 64
"""Beams whose depths and directions lie side by side in one table, see ``lay_beams``; there is a multiple of it."""

LANES = 8
"""Numbers in float64 that are worked on at once."""

ROW = np.uint64(CHUNK)
ONE, TWO, THREE, FOUR = np.uint64(1), np.uint64(2), np.uint64(3), np.uint64(4)
FIVE, SIX, SEVEN, EIGHT = np.uint64(5), np.uint64(6), np.uint64(7), np.uint64(8)
"""Unsigned, so that an index needs no test for negative numbers, which would keep the loop from running in lanes."""

RUN = 16
"""Beams that are cast together; spans begin at a multiple of it."""

LENGTH = np.uint64(RUN)
AHEAD, ASIDE, AWAY = np.uint64(BLOCK), np.uint64(2 * BLOCK), 3 * BLOCK
"""Where the directions of a block begin, after its depths, and where the next block does."""

SLACK = 3e-7
"""Segments are widened at both ends by up to three times this angle [rad] at the farther end, so that no beam slips
between two that share a vertex."""

MARGIN = 0.008
"""What is added to both ends of an angle of sight [rad]: the error of ``rough_angle``, and room for the slack."""

HALF_TURN, TURN = 3.1415, 6.2831853
"""A little less than pi [rad], beyond which a direction is taken for one at the other end; and a full turn."""


@kernel(inlined=True)
def prepare_segments(count: int, eye: Eye, far: float, rows: Floats, limits: Floats, slopes: Rays, spans: Spans) -> int:
    """Write what the beams need to know of segments, and which of them are kept: those in range that show their front.

    Args:
        count: Number of segments, at most CHUNK.
        eye: The sensor's place [m], and cosine and sine of its heading.
        far: Range of the sensor [m].
        rows: Ends in the world frame [m], one segment after the other: ax, ay, bx, by, shape ``(4 * n,)``.
        limits: The largest a x b [m2] with which each shows its front: 0, or inf where both sides are seen, -inf for
            what is not seen at all, shape ``(n,)``.
        slopes: Written, in the sensor frame: n, q [1/m], slack [1/m] and both ends [m], shape ``(9 * CHUNK,)``.
        spans: Written: 1 for segments that are kept, else 0, in the first CHUNK; shape ``(4 * CHUNK,)``.

    Returns:
        More than 0 if some would be kept but are seen edge-on, so that they need the care of ``inverse_depth_segment``;
        these are marked by -1.
    """
    n_edges, whole = 0, count // LANES * LANES
    for part in range(2):
        # What is left after the whole lanes is done together with rows of before: one by one it would take longer.
        k = 0 if part == 0 else max(count - LANES, 0)
        n = whole if part == 0 else count - k
        if part == 0 or whole < count:
            n_edges += prepare_lanes(n, eye, far, rows[4 * k :], limits[k:], slopes[k:], spans[k:])
    return n_edges


@kernel(inlined=True)
def prepare_lanes(count: int, eye: Eye, far: float, rows: Floats, limits: Floats, slopes: Rays, spans: Spans) -> int:
    """Do the work of ``prepare_segments``."""
    n_edges, (x, y, cosine, sine) = np.int64(0), eye
    for j in range(np.uint64(count)):
        at = FOUR * j
        gx, gy, hx, hy = rows[at] - x, rows[at + ONE] - y, rows[at + TWO] - x, rows[at + THREE] - y
        ax, ay = cosine * gx + sine * gy, cosine * gy - sine * gx
        bx, by = cosine * hx + sine * hy, cosine * hy - sine * hx
        cross = gx * hy - gy * hx
        ex, ey = hx - gx, hy - gy
        a2, b2, length2 = gx * gx + gy * gy, hx * hx + hy * hy, ex * ex + ey * ey
        along = -(gx * ex + gy * ey)
        least = cross * cross
        least = b2 * length2 if along >= length2 else least
        least = a2 * length2 if along <= 0.0 else least
        wanted = (cross <= limits[j]) & (least <= far * far * length2)
        clear = cross * cross > EDGE_ON * EDGE_ON * a2 * b2
        share = 1.0 / cross
        normal_x, normal_y = (by - ay) * share, (ax - bx) * share
        place_x, place_y = -(ay + by) * share, (ax + bx) * share
        slopes[j], slopes[j + ROW] = np.float32(normal_x), np.float32(normal_y)
        slopes[j + ROW * TWO], slopes[j + ROW * THREE] = np.float32(place_x), np.float32(place_y)
        spread = np.abs(normal_x) + np.abs(normal_y) + np.abs(place_x) + np.abs(place_y)
        slopes[j + ROW * FOUR] = np.float32(SLACK * spread)
        slopes[j + ROW * FIVE], slopes[j + ROW * SIX] = np.float32(ax), np.float32(ay)
        slopes[j + ROW * SEVEN], slopes[j + ROW * EIGHT] = np.float32(bx), np.float32(by)
        edge = wanted & (not clear)
        spans[j] = np.int32(wanted) - np.int32(2) * np.int32(edge)
        n_edges += np.int64(edge)
    return int(n_edges)


@kernel(inlined=True)
def prepare_discs(count: int, cosine: float, sine: float, near: Floats, slopes: Rays, spans: Spans) -> int:
    """Write what the beams need to know of discs.

    Args:
        count: Number of discs, at most CHUNK.
        cosine: Of the sensor's heading.
        sine: Of the sensor's heading.
        near: Centres relative to the sensor, in the world frame, and radii [m]: x, y, r, shape ``(3 * CHUNK,)``.
        slopes: Written, in the sensor frame: centre [m], squared radius [m2], 1 / (c.c - r^2) [1/m2] and the rough
            half of the angle of sight [rad], shape ``(5 * CHUNK,)``.
        spans: Written: 1 in the first CHUNK; shape ``(4 * CHUNK,)``.

    Returns:
        How many hold the sensor, so that ``inverse_depth_disc`` has to cast them; these are marked by -1.
    """
    n_around = np.int64(0)
    for j in range(count):
        x, y, r = near[j], near[j + CHUNK], near[j + 2 * CHUNK]
        distance2, r2 = x * x + y * y, r * r
        power = distance2 - r2
        slopes[j], slopes[j + CHUNK] = np.float32(cosine * x + sine * y), np.float32(cosine * y - sine * x)
        slopes[j + 2 * CHUNK], slopes[j + 3 * CHUNK] = np.float32(r2), np.float32(1.0 / power)
        sine2 = r2 / distance2
        slopes[j + 4 * CHUNK] = np.float32(np.sqrt(sine2) * (1.0 + 0.5708 * sine2))
        around = power <= 1e-30
        spans[j] = np.int32(1) - np.int32(2) * np.int32(around)
        n_around += np.int64(around)
    return int(n_around)


@kernel(contract=True, inlined=True)
def rough_angle(x: np.float32, y: np.float32) -> np.float32:
    """Return the direction of (x, y) [rad] with an error of less than 0.0065 rad; NaN where there is none."""
    across, up = np.abs(x), np.abs(y)
    t = up / (across + up)
    u = t * (np.float32(1.5708) - np.float32(0.728) * (np.float32(1.0) - t) * (np.float32(1.0) - t - t))
    u = u if x >= np.float32(0.0) else np.float32(3.14159265) - u
    return np.float32(u if y >= np.float32(0.0) else -u)


@kernel(contract=True, inlined=True)
def span_segments(count: int, n_beams: int, first: np.float32, density: np.float32, slopes: Rays, spans: Spans) -> None:
    """Write for each segment the first of the beams that may meet it, and in how many runs they lie.

    Args:
        count: Number of segments.
        n_beams: Number of beams, a multiple of BLOCK.
        first: Direction of the first beam [rad].
        density: Beams per rad; 0 where the beams are not evenly spread, so that all are cast.
        slopes: From ``prepare_segments``.
        spans: Written: first beams in the second CHUNK, numbers of runs in the third; lanes are filled up, so what
            follows the last segment means nothing.
    """
    for j in range((count + RUN - 1) // RUN * RUN):
        ax, ay, bx, by = slopes[j + 5 * CHUNK], slopes[j + 6 * CHUNK], slopes[j + 7 * CHUNK], slopes[j + 8 * CHUNK]
        a, b = rough_angle(ax, ay), rough_angle(bx, by)
        turns_left = ax * by - ay * bx > np.float32(0.0)
        low, high = (a if turns_left else b), (b if turns_left else a)
        begin, runs = span(low, high, n_beams, first, density)
        spans[j + CHUNK], spans[j + 2 * CHUNK] = begin, runs


@kernel(contract=True, inlined=True)
def span_discs(count: int, n_beams: int, first: np.float32, density: np.float32, slopes: Rays, spans: Spans) -> None:
    """Write for each disc the first of the beams that may meet it, and in how many runs they lie."""
    for j in range((count + RUN - 1) // RUN * RUN):
        middle, half = rough_angle(slopes[j], slopes[j + CHUNK]), slopes[j + 4 * CHUNK]
        begin, runs = span(middle - half, middle + half, n_beams, first, density)
        spans[j + CHUNK], spans[j + 2 * CHUNK] = begin, runs


@kernel(contract=True, inlined=True)
def span(
    low: np.float32, high: np.float32, n_beams: int, first: np.float32, density: np.float32
) -> tuple[np.int32, np.int32]:
    """Return the first beam between two directions and the number of runs; after the last run comes the first one.

    All runs where the beams are not evenly spread.
    """
    zero, one, turn, half_turn = np.float32(0.0), np.float32(1.0), np.float32(TURN), np.float32(HALF_TURN)
    share, whole = np.float32(1.0 / RUN), np.float32(n_beams)
    low, high = low - np.float32(MARGIN), high + np.float32(MARGIN)
    is_across = (low > high) | (low < -half_turn) | (high > half_turn)
    low, high = low + turn if low < -half_turn else low, high - turn if high > half_turn else high
    begin, end = (low - first) * density, (high - first) * density + one
    begin, end = begin if begin > zero else zero, end if end < whole - one else whole - one
    begin, end = begin if begin < whole else whole, end if end > -one else -one
    place, end = np.floor(begin * share), end + whole if is_across else end
    runs, most = np.floor(end * share) - place + one, whole * share
    is_part = (density > zero) & (runs < most)
    place = place * np.float32(RUN) if is_part & (place < most) else zero
    return np.int32(place), np.int32(runs if is_part else most)


@kernel(inlined=True)
def list_kept(count: int, spans: Spans) -> int:
    """Write the numbers of the primitives marked by 1 one after the other, in the last CHUNK; return how many."""
    n = np.uint64(0)
    for j in range(np.uint64(count)):
        spans[n + ROW * THREE] = j
        n += np.uint64(spans[j] > 0)
    return int(n)


@kernel(inlined=True)
def lay_beams(beams_x: Rays, beams_y: Rays, rays: Rays) -> None:
    """Write beams where they are cast.

    Distances in one table that are known beforehand let the compiler see that depths and directions do not overlap.

    Args:
        beams_x: Unit directions in the sensor frame, shape ``(n_beams,)``, a multiple of BLOCK.
        beams_y: As ``beams_x``.
        rays: Written, block after block: inverse depths, which stay as they are, and both parts of the directions,
            BLOCK numbers each, shape ``(3 * n_beams,)``.
    """
    for j in range(beams_x.shape[0]):
        at = j + 2 * BLOCK * (j // BLOCK)
        rays[at + BLOCK], rays[at + 2 * BLOCK] = beams_x[j], beams_y[j]


@kernel(inlined=True)
def clear_depths(rays: Rays) -> None:
    """Begin with beams that meet nothing."""
    for begin in range(0, rays.shape[0], AWAY):
        depths = rays[begin : begin + BLOCK]
        for i in range(BLOCK):
            depths[i] = np.float32(0.0)


@kernel(contract=True, inlined=True)
def raise_by_segments(n: int, slopes: Rays, spans: Spans, rays: Rays) -> None:
    """Raise the inverse depths in ``rays`` [1/m] where beams meet the listed segments, from either side."""
    zero, n_beams = np.float32(0.0), np.uint64(rays.shape[0] // 3)
    for m in range(np.uint64(n)):
        s = np.uint64(spans[m + ROW * THREE])
        normal_x, normal_y = slopes[s], slopes[s + ROW]
        place_x, place_y = slopes[s + ROW * TWO], slopes[s + ROW * THREE]
        slack, p = slopes[s + ROW * FOUR], np.uint64(spans[s + ROW])
        for _ in range(spans[s + ROW * TWO]):
            at = p + TWO * AHEAD * (p // AHEAD)
            for i in range(LENGTH):
                x, y = rays[at + AHEAD + i], rays[at + ASIDE + i]
                depth = normal_x * x + normal_y * y
                place = place_x * x + place_y * y
                depth = depth if depth + slack >= np.abs(place) else zero
                depth = depth if depth > rays[at + i] else rays[at + i]
                rays[at + i] = depth if depth > zero else zero
            p = p + LENGTH if p + LENGTH < n_beams else np.uint64(0)


@kernel(contract=True, inlined=True)
def raise_by_discs(n: int, slopes: Rays, spans: Spans, rays: Rays) -> None:
    """Raise the inverse depths in ``rays`` [1/m] where beams meet the listed discs, seen from outside."""
    zero, n_beams = np.float32(0.0), np.uint64(rays.shape[0] // 3)
    for m in range(np.uint64(n)):
        s = np.uint64(spans[m + ROW * THREE])
        cx, cy, radius2, scale = slopes[s], slopes[s + ROW], slopes[s + ROW * TWO], slopes[s + ROW * THREE]
        p = np.uint64(spans[s + ROW])
        for _ in range(spans[s + ROW * TWO]):
            at = p + TWO * AHEAD * (p // AHEAD)
            for i in range(LENGTH):
                x, y = rays[at + AHEAD + i], rays[at + ASIDE + i]
                ahead, aside = cx * x + cy * y, cx * y - cy * x
                room = radius2 - aside * aside
                depth = (ahead + np.sqrt(room if room > zero else zero)) * scale
                inner = room if room < ahead else ahead
                depth = depth if inner >= zero else zero
                depth = depth if depth > rays[at + i] else rays[at + i]
                rays[at + i] = depth if depth > zero else zero
            p = p + LENGTH if p + LENGTH < n_beams else np.uint64(0)
