"""Casts beams against many segments and discs at once, with vector instructions.

``simulator/geometry/rays.py`` treats one primitive at a time. Here the work is split: first, all primitives of a chunk
are prepared in lanes (whether they are visible, the coefficients of their inverse depth, which beams may meet them).
Then each visible primitive is cast against the beams of its span. The tables of a chunk are fields of one record:
constant offsets from one address show the compiler that they do not overlap.

On the line through a and b, the inverse depth of a beam with unit direction d is n.d with n = (by - ay, ax - bx) / (a x
b). With m = a + b, the position on the segment, from -1 at a to 1 at b, is (q.d) / (n.d) with q = (-my, mx) / (a x b).
So a beam meets the segment where abs(q.d) <= n.d, which takes two dot products, an absolute value and a comparison.
"""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats, Rays, Record
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.geometry.rays import EDGE_ON

CHUNK = 64
"""Number of primitives in a chunk."""

BLOCK = 64
"""Number of beams in a block of ``lay_beams``. Tables hold whole blocks."""

LANES = 8
"""Number of float64 lanes of a vector."""

ONE, TWO, THREE, FOUR = np.uint64(1), np.uint64(2), np.uint64(3), np.uint64(4)
"""Unsigned: signed indices are tested for negative values, which prevents vector instructions."""

RUN = 16
"""Number of beams cast together. Spans begin at multiples of it."""

LENGTH = np.uint64(RUN)
AHEAD, ASIDE, AWAY = np.uint64(BLOCK), np.uint64(2 * BLOCK), 3 * BLOCK
"""Offsets of the directions of a block, after its depths, and of the next block."""

SLACK = 3e-7
"""Segments are widened at both ends by up to three times this angle [rad] at the farther end, so that no beam slips
between two that share a vertex."""

MARGIN = 0.008
"""Margin at both ends of an angle of sight [rad]: error of ``rough_angle``, and slack of segments."""

HALF_TURN, TURN = 3.1415, 6.2831853
"""Slightly less than pi [rad], beyond which a direction may belong to the other end; and a full turn."""


def _columns(dtype: type[np.generic], *names: str) -> list[tuple[str, type[np.generic], tuple[int]]]:
    return [(name, dtype, (CHUNK,)) for name in names]


_SPANS = _columns(np.int32, "mark", "begin", "runs", "kept")

_NORMALS = _columns(np.float32, "normal_x", "normal_y", "place_x", "place_y", "slack")

SIDES = np.dtype((np.record, [*_NORMALS, *_columns(np.float32, "ax", "ay", "bx", "by"), *_SPANS]))
"""What beams need to know of segments, in the sensor frame: n, q and slack [1/m], and both ends [m].

``mark`` is 1 for those that are kept, -1 for those that need the care of ``rays``, else 0; ``begin`` the first of the
beams that may meet one, ``runs`` in how many runs these lie. ``kept`` lists the numbers of those that are kept."""

ROUNDS = np.dtype((np.record, [*_columns(np.float32, "x", "y", "radius2", "scale", "half"), *_SPANS]))
"""What beams need to know of discs, in the sensor frame: centre [m], squared radius [m2], 1 / (c.c - r^2) [1/m2] and
the rough half of the angle of sight [rad]. The rest is as in ``SIDES``."""

DISCS = np.dtype((np.record, _columns(np.float64, "x", "y", "radius")))
"""Discs: centres relative to the sensor, in the directions of the world frame, and radii [m]."""


class Eye(NamedTuple):
    """Where a sensor is, in the world frame.

    Attributes:
        x: Its place [m].
        y: Its place [m].
        cosine: Cosine of its heading.
        sine: Sine of its heading.
    """

    x: float
    y: float
    cosine: float
    sine: float


class Fan(NamedTuple):
    """How the beams of a sensor are spread.

    Attributes:
        n_beams: Number of beams, a multiple of BLOCK.
        first: Direction of the first beam [rad].
        density: Beams per rad; 0 where the beams are not evenly spread, so that all are cast.
    """

    n_beams: int
    first: np.float32
    density: np.float32


@kernel(inlined=True)
def prepare_segments(count: int, eye: Eye, far: float, rows: Floats, limits: Floats, sides: Record) -> int:
    """Write what the beams need to know of segments, and which of them are kept: those in range that show their front.

    Args:
        count: Number of segments, at most CHUNK.
        eye: The sensor.
        far: Range of the sensor [m].
        rows: Ends in the world frame [m], one segment after the other: ax, ay, bx, by, shape ``(4 * n,)``.
        limits: The largest a x b [m2] with which each shows its front: 0, or inf where both sides are seen, -inf for
            what is not seen at all, shape ``(n,)``.
        sides: Written, except for spans, see ``SIDES``.

    Returns:
        More than 0 if some would be kept but are seen edge-on, so that they need the care of ``inverse_depth_segment``;
        these are marked by -1.
    """
    whole = count // LANES * LANES
    n_edges = prepare_lanes(0, whole, eye, far, rows, limits, sides)
    if whole < count:
        # The rest after the whole lanes is done together with earlier rows, which is faster than one by one.
        n_edges += prepare_lanes(max(count - LANES, 0), count, eye, far, rows, limits, sides)
    return n_edges


@kernel(inlined=True)
def prepare_lanes(begin: int, end: int, eye: Eye, far: float, rows: Floats, limits: Floats, sides: Record) -> int:
    """Do the work of ``prepare_segments`` for some of the segments."""
    x, y, cosine, sine = eye
    n_edges = np.int64(0)
    for j in range(np.uint64(begin), np.uint64(end)):
        # Both ends relative to the sensor: ``g`` and ``h`` in the world frame, ``a`` and ``b`` in its own.
        at = FOUR * j
        gx, gy, hx, hy = rows[at] - x, rows[at + ONE] - y, rows[at + TWO] - x, rows[at + THREE] - y
        ax, ay = cosine * gx + sine * gy, cosine * gy - sine * gx
        bx, by = cosine * hx + sine * hy, cosine * hy - sine * hx
        cross = gx * hy - gy * hx
        ex, ey = hx - gx, hy - gy
        a2, b2, length2 = gx * gx + gy * gy, hx * hx + hy * hy, ex * ex + ey * ey
        # ``least`` is the squared distance of the segment times ``length2``, which spares a division: that of the line,
        # or of the nearer end if the foot of the perpendicular is outside.
        along = -(gx * ex + gy * ey)
        least = cross * cross
        least = b2 * length2 if along >= length2 else least
        least = a2 * length2 if along <= 0.0 else least
        meets = (cross <= limits[j]) & (least <= far * far * length2)
        # As in ``rays``: seen under a clear angle, not edge-on.
        clear = cross * cross > EDGE_ON * EDGE_ON * a2 * b2
        share = 1.0 / cross
        normal_x, normal_y = (by - ay) * share, (ax - bx) * share
        place_x, place_y = -(ay + by) * share, (ax + bx) * share
        sides.normal_x[j], sides.normal_y[j] = np.float32(normal_x), np.float32(normal_y)
        sides.place_x[j], sides.place_y[j] = np.float32(place_x), np.float32(place_y)
        spread = np.abs(normal_x) + np.abs(normal_y) + np.abs(place_x) + np.abs(place_y)
        sides.slack[j] = np.float32(SLACK * spread)
        sides.ax[j], sides.ay[j] = np.float32(ax), np.float32(ay)
        sides.bx[j], sides.by[j] = np.float32(bx), np.float32(by)
        edge = meets & (not clear)
        # 1 for those that are kept, -1 if seen edge-on as well, else 0.
        sides.mark[j] = np.int32(meets) - np.int32(2) * np.int32(edge)
        n_edges += np.int64(edge)
    return int(n_edges)


@kernel(inlined=True)
def prepare_discs(count: int, eye: Eye, discs: Record, rounds: Record) -> int:
    """Write what the beams need to know of discs.

    Args:
        count: Number of discs, at most CHUNK.
        eye: The sensor.
        discs: The discs, see ``DISCS``.
        rounds: Written, except for spans, see ``ROUNDS``.

    Returns:
        How many hold the sensor, so that ``inverse_depth_disc`` has to cast them; these are marked by -1.
    """
    n_around, cosine, sine = np.int64(0), eye.cosine, eye.sine
    for j in range(count):
        x, y, r = discs.x[j], discs.y[j], discs.radius[j]
        distance2, r2 = x * x + y * y, r * r
        power = distance2 - r2
        rounds.x[j], rounds.y[j] = np.float32(cosine * x + sine * y), np.float32(cosine * y - sine * x)
        rounds.radius2[j], rounds.scale[j] = np.float32(r2), np.float32(1.0 / power)
        sine2 = r2 / distance2
        # arcsin(s) is at most s + (pi / 2 - 1) s^3, which is exact at 0 and 1.
        rounds.half[j] = np.float32(np.sqrt(sine2) * (1.0 + 0.5708 * sine2))
        around = power <= 1e-30
        rounds.mark[j] = np.int32(1) - np.int32(2) * np.int32(around)
        n_around += np.int64(around)
    return int(n_around)


@kernel(contract=True, inlined=True)
def rough_angle(x: np.float32, y: np.float32) -> np.float32:
    """Return the direction of (x, y) [rad] with an error of less than 0.0065 rad; NaN where there is none."""
    across, up = np.abs(x), np.abs(y)
    # t runs from 0 to 1 over the first quadrant; the cubic in t is exact at 0, 45 and 90 degrees.
    t = up / (across + up)
    u = t * (np.float32(1.5708) - np.float32(0.728) * (np.float32(1.0) - t) * (np.float32(1.0) - t - t))
    u = u if x >= np.float32(0.0) else np.float32(3.14159265) - u
    return np.float32(u if y >= np.float32(0.0) else -u)


@kernel(contract=True, inlined=True)
def span_segments(count: int, fan: Fan, sides: Record) -> None:
    """Write for each segment the first of the beams that may meet it, and in how many runs they lie.

    Args:
        count: Number of segments.
        fan: How the beams are spread.
        sides: From ``prepare_segments``; lanes are filled up, so what follows the last segment means nothing.
    """
    for j in range((count + RUN - 1) // RUN * RUN):
        ax, ay, bx, by = sides.ax[j], sides.ay[j], sides.bx[j], sides.by[j]
        a, b = rough_angle(ax, ay), rough_angle(bx, by)
        # Seen from the sensor, the beams sweep counter-clockwise from ``low`` to ``high``.
        turns_left = ax * by - ay * bx > np.float32(0.0)
        low, high = (a if turns_left else b), (b if turns_left else a)
        sides.begin[j], sides.runs[j] = span(low, high, fan)


@kernel(contract=True, inlined=True)
def span_discs(count: int, fan: Fan, rounds: Record) -> None:
    """Write for each disc the first of the beams that may meet it, and in how many runs they lie."""
    for j in range((count + RUN - 1) // RUN * RUN):
        middle, half = rough_angle(rounds.x[j], rounds.y[j]), rounds.half[j]
        rounds.begin[j], rounds.runs[j] = span(middle - half, middle + half, fan)


@kernel(contract=True, inlined=True)
def span(low: np.float32, high: np.float32, fan: Fan) -> tuple[np.int32, np.int32]:
    """Return the first beam between two directions and the number of runs; after the last run comes the first one.

    All runs where the beams are not evenly spread.
    """
    zero, unit, turn, half_turn = np.float32(0.0), np.float32(1.0), np.float32(TURN), np.float32(HALF_TURN)
    first, density = fan.first, fan.density
    share, whole = np.float32(1.0 / RUN), np.float32(fan.n_beams)
    low, high = low - np.float32(MARGIN), high + np.float32(MARGIN)
    # The span contains the direction pi, where angles jump to -pi: it goes on from the last beam to the first one.
    is_across = (low > high) | (low < -half_turn) | (high > half_turn)
    low, high = low + turn if low < -half_turn else low, high - turn if high > half_turn else high
    # Numbers of beams, not rounded yet, limited to those that there are.
    begin, end = (low - first) * density, (high - first) * density + unit
    begin, end = begin if begin > zero else zero, end if end < whole - unit else whole - unit
    begin, end = begin if begin < whole else whole, end if end > -unit else -unit
    # From here on in runs of RUN beams; a span across pi ends in the second round.
    place, end = np.floor(begin * share), end + whole if is_across else end
    runs, most = np.floor(end * share) - place + unit, whole * share
    is_part = (density > zero) & (runs < most)
    place = place * np.float32(RUN) if is_part & (place < most) else zero
    return np.int32(place), np.int32(runs if is_part else most)


@kernel(inlined=True)
def list_kept(count: int, chunk: Record) -> int:
    """Write the numbers of the primitives of a chunk that are marked by 1 into ``kept``; return how many."""
    n = np.uint64(0)
    for j in range(np.uint64(count)):
        # Without a branch: what is not kept is overwritten by the next one.
        chunk.kept[n] = j
        n += np.uint64(chunk.mark[j] > 0)
    return int(n)


@kernel(inlined=True)
def lay_beams(beams_x: Rays, beams_y: Rays, rays: Rays) -> None:
    """Write beams where they are cast.

    Constant offsets within one table let the compiler see that depths and directions do not overlap.

    Args:
        beams_x: Unit directions in the sensor frame, shape ``(n_beams,)``, a multiple of BLOCK.
        beams_y: As ``beams_x``.
        rays: Written, block after block: inverse depths, which stay as they are, and both parts of the directions,
            BLOCK numbers each, shape ``(3 * n_beams,)``.
    """
    for j in range(beams_x.shape[0]):
        # Beam j is number j % BLOCK of its block, and each block takes 3 * BLOCK places.
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
def raise_by_segments(n: int, sides: Record, rays: Rays) -> None:
    """Raise the inverse depths in ``rays`` [1/m] where beams meet the listed segments, from either side."""
    zero, n_beams = np.float32(0.0), np.uint64(rays.shape[0] // 3)
    for m in range(np.uint64(n)):
        s = np.uint64(sides.kept[m])
        normal_x, normal_y = sides.normal_x[s], sides.normal_y[s]
        place_x, place_y = sides.place_x[s], sides.place_y[s]
        slack, p = sides.slack[s], np.uint64(sides.begin[s])
        for _ in range(sides.runs[s]):
            # Place of the depth of beam p, see ``lay_beams``; its directions follow AHEAD and ASIDE behind.
            at = p + TWO * AHEAD * (p // AHEAD)
            for i in range(LENGTH):
                x, y = rays[at + AHEAD + i], rays[at + ASIDE + i]
                depth = normal_x * x + normal_y * y
                place = place_x * x + place_y * y
                # abs(q.d) <= n.d: the beam passes between both ends, and ahead.
                depth = depth if depth + slack >= np.abs(place) else zero
                # No depth is below 0. The second comparison lets the compiler store every lane with a ``max``
                # instruction; with the first one alone it stores some of them under a mask.
                depth = depth if depth > rays[at + i] else rays[at + i]
                rays[at + i] = depth if depth > zero else zero
            p = p + LENGTH if p + LENGTH < n_beams else np.uint64(0)


@kernel(contract=True, inlined=True)
def raise_by_discs(n: int, rounds: Record, rays: Rays) -> None:
    """Raise the inverse depths in ``rays`` [1/m] where beams meet the listed discs, seen from outside."""
    zero, n_beams = np.float32(0.0), np.uint64(rays.shape[0] // 3)
    for m in range(np.uint64(n)):
        s = np.uint64(rounds.kept[m])
        cx, cy, radius2, scale = rounds.x[s], rounds.y[s], rounds.radius2[s], rounds.scale[s]
        p = np.uint64(rounds.begin[s])
        for _ in range(rounds.runs[s]):
            at = p + TWO * AHEAD * (p // AHEAD)
            for i in range(LENGTH):
                x, y = rays[at + AHEAD + i], rays[at + ASIDE + i]
                ahead, aside = cx * x + cy * y, cx * y - cy * x
                room = radius2 - aside * aside
                depth = (ahead + np.sqrt(room if room > zero else zero)) * scale
                inner = room if room < ahead else ahead
                depth = depth if inner >= zero else zero
                # As in ``raise_by_segments``: two ``max`` instructions, no mask.
                depth = depth if depth > rays[at + i] else rays[at + i]
                rays[at + i] = depth if depth > zero else zero
            p = p + LENGTH if p + LENGTH < n_beams else np.uint64(0)
