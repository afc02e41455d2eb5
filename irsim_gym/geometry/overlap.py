"""Overlap of and distance between outlines.

An outline is a range of rows of a segment table and of a disc table. The segments of a solid outline are the
boundary of an area (one or more closed chains, inside by the even-odd rule), those of another are curves; a disc
is an area. All sets are closed: touching is overlapping.
"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.geometry.polygons import contains_point
from irsim_gym.geometry.segments import gap2, point_segment_distance2, segment_segment_distance2, segments_intersect
from irsim_gym.jit import kernel

SURE = 1e-6
"""Segments whose line is farther away than would matter by this much [m] are passed over; rounding is far smaller."""


@kernel
def outlines_overlap(
    seg_a: Floats,
    sa: int,
    na: int,
    disc_a: Floats,
    da: int,
    ma: int,
    solid_a: bool,
    seg_b: Floats,
    sb: int,
    nb: int,
    disc_b: Floats,
    db: int,
    mb: int,
    solid_b: bool,
) -> bool:
    """Return whether two outlines have a point in common.

    Args:
        seg_a: Segment table of a's world [m], shape ``(segment, 4)``.
        sa: First row of a's segments.
        na: Number of them.
        disc_a: Disc table of a's world [m], shape ``(disc, 3)``.
        da: First row of a's discs.
        ma: Number of them.
        solid_a: The segments of a bound an area.
        seg_b: As for a.
        sb: As for a.
        nb: As for a.
        disc_b: As for a.
        db: As for a.
        mb: As for a.
        solid_b: As for a.
    """
    if discs_overlap(disc_a, da, ma, disc_b, db, mb):
        return True
    if discs_meet_segments(disc_a, da, ma, seg_b, sb, nb) or discs_meet_segments(disc_b, db, mb, seg_a, sa, na):
        return True
    for s in range(sa, sa + na):
        ax, ay, bx, by = seg_a[s, 0], seg_a[s, 1], seg_a[s, 2], seg_a[s, 3]
        for q in range(sb, sb + nb):
            if segments_intersect(ax, ay, bx, by, seg_b[q, 0], seg_b[q, 1], seg_b[q, 2], seg_b[q, 3]):
                return True
    if solid_a and holds_part(seg_a, sa, na, seg_b, sb, nb, disc_b, db, mb):
        return True
    return solid_b and holds_part(seg_b, sb, nb, seg_a, sa, na, disc_a, da, ma)


@kernel
def outline_distance(
    seg_a: Floats,
    sa: int,
    na: int,
    disc_a: Floats,
    da: int,
    ma: int,
    solid_a: bool,
    seg_b: Floats,
    sb: int,
    nb: int,
    disc_b: Floats,
    db: int,
    mb: int,
    solid_b: bool,
    limit: float,
) -> float:
    """Return the distance [m] between two outlines: 0 when they overlap, ``limit`` when it is not smaller.

    Arguments as in ``outlines_overlap``; ``limit`` [m] may be inf.
    """
    if outlines_overlap(seg_a, sa, na, disc_a, da, ma, solid_a, seg_b, sb, nb, disc_b, db, mb, solid_b):
        return 0.0
    best = disc_disc_distance(disc_a, da, ma, disc_b, db, mb, limit)
    best = disc_segment_distance(disc_a, da, ma, seg_b, sb, nb, best)
    best = disc_segment_distance(disc_b, db, mb, seg_a, sa, na, best)
    best2 = best * best
    found = False
    for s in range(sa, sa + na):
        ax, ay, bx, by = seg_a[s, 0], seg_a[s, 1], seg_a[s, 2], seg_a[s, 3]
        for q in range(sb, sb + nb):
            cx, cy, dx, dy = seg_b[q, 0], seg_b[q, 1], seg_b[q, 2], seg_b[q, 3]
            if gap2(ax, ay, bx, by, cx, cy, dx, dy) < best2:
                distance2 = segment_segment_distance2(ax, ay, bx, by, cx, cy, dx, dy)
                if distance2 < best2:
                    best2, found = distance2, True
    return float(np.sqrt(best2)) if found else best


@kernel
def point_outline_distance(
    x: float, y: float, seg: Floats, s: int, n: int, disc: Floats, d: int, m: int, solid: bool
) -> float:
    """Return the distance [m] of a point from an outline: 0 inside an area, inf if the outline is empty.

    Args:
        x: Position [m].
        y: Position [m].
        seg: Segment table [m], shape ``(segment, 4)``.
        s: First row of the outline's segments.
        n: Number of them.
        disc: Disc table [m], shape ``(disc, 3)``.
        d: First row of the outline's discs.
        m: Number of them.
        solid: The segments bound an area.
    """
    if solid and contains_point(seg, s, n, x, y):
        return 0.0
    best2 = np.inf
    for i in range(s, s + n):
        best2 = min(best2, point_segment_distance2(x, y, seg[i, 0], seg[i, 1], seg[i, 2], seg[i, 3]))
    best = np.sqrt(best2)
    for i in range(d, d + m):
        dx, dy = disc[i, 0] - x, disc[i, 1] - y
        best = min(best, max(np.sqrt(dx * dx + dy * dy) - disc[i, 2], 0.0))
    return float(best)


@kernel(inlined=True)
def disc_meets_outline(
    x: float, y: float, radius: float, seg: Floats, s: int, n: int, disc: Floats, d: int, m: int, solid: bool
) -> bool:
    """Return whether a disc and an outline have a point in common: what ``outlines_overlap`` says, for most robots.

    Arguments as in ``disc_outline_distance``.
    """
    for i in range(d, d + m):
        dx, dy, both = x - disc[i, 0], y - disc[i, 1], radius + disc[i, 2]
        if dx * dx + dy * dy <= both * both:
            return True
    radius2, out2 = radius * radius, (radius + SURE) * (radius + SURE)
    for i in range(s, s + n):
        ax, ay, bx, by = seg[i, 0], seg[i, 1], seg[i, 2], seg[i, 3]
        is_out = line_is_out(x, y, ax, ay, bx, by, out2)
        if not is_out and point_segment_distance2(x, y, ax, ay, bx, by) <= radius2:
            return True
    return solid and contains_point(seg, s, n, x, y)


@kernel(inlined=True)
def line_is_out(x: float, y: float, ax: float, ay: float, bx: float, by: float, out2: float) -> bool:
    """Return whether the line through a and b lies farther from a point than the root of ``out2`` [m2]."""
    dx, dy = bx - ax, by - ay
    across = (x - ax) * dy - (y - ay) * dx
    return across * across > out2 * (dx * dx + dy * dy)


@kernel(inlined=True)
def disc_outline_distance(
    x: float,
    y: float,
    radius: float,
    seg: Floats,
    s: int,
    n: int,
    disc: Floats,
    d: int,
    m: int,
    solid: bool,
    limit: float,
) -> float:
    """Return the distance [m] of a disc from an outline, the same number as ``outline_distance`` in fewer steps.

    Args:
        x: Centre of the disc [m].
        y: Centre of the disc [m].
        radius: Its radius [m].
        seg: Segment table [m], shape ``(segment, 4)``.
        s: First row of the outline's segments.
        n: Number of them.
        disc: Disc table [m], shape ``(disc, 3)``.
        d: First row of the outline's discs.
        m: Number of them.
        solid: The segments bound an area.
        limit: Returned when the distance is not smaller [m]; may be inf.
    """
    best = limit
    for i in range(d, d + m):
        dx, dy, both = x - disc[i, 0], y - disc[i, 1], radius + disc[i, 2]
        distance2 = dx * dx + dy * dy
        if distance2 <= both * both:
            return 0.0
        best = min(best, np.sqrt(distance2) - both)
    if n == 0:
        return best
    least2, out2 = np.inf, (best + radius + SURE) * (best + radius + SURE)
    for i in range(s, s + n):
        ax, ay, bx, by = seg[i, 0], seg[i, 1], seg[i, 2], seg[i, 3]
        if not line_is_out(x, y, ax, ay, bx, by, out2):
            least2 = min(least2, point_segment_distance2(x, y, ax, ay, bx, by))
    if least2 <= radius * radius or (solid and contains_point(seg, s, n, x, y)):
        return 0.0
    return float(min(best, np.sqrt(least2) - radius))


@kernel
def discs_overlap(disc_a: Floats, da: int, ma: int, disc_b: Floats, db: int, mb: int) -> bool:
    """Return whether a disc of a touches a disc of b."""
    for i in range(da, da + ma):
        for j in range(db, db + mb):
            dx, dy = disc_a[i, 0] - disc_b[j, 0], disc_a[i, 1] - disc_b[j, 1]
            radius = disc_a[i, 2] + disc_b[j, 2]
            if dx * dx + dy * dy <= radius * radius:
                return True
    return False


@kernel
def discs_meet_segments(discs: Floats, d: int, m: int, segments: Floats, s: int, n: int) -> bool:
    """Return whether a disc touches a segment."""
    for i in range(d, d + m):
        x, y, radius2 = discs[i, 0], discs[i, 1], discs[i, 2] * discs[i, 2]
        for j in range(s, s + n):
            ax, ay, bx, by = segments[j, 0], segments[j, 1], segments[j, 2], segments[j, 3]
            if point_segment_distance2(x, y, ax, ay, bx, by) <= radius2:
                return True
    return False


@kernel
def holds_part(area: Floats, sa: int, na: int, segments: Floats, s: int, n: int, discs: Floats, d: int, m: int) -> bool:
    """Return whether an area holds a disc's centre or the first point of a chain of another outline.

    Where no boundaries cross, a chain lies wholly inside or outside, so one point of each is enough.
    """
    for i in range(d, d + m):
        if contains_point(area, sa, na, discs[i, 0], discs[i, 1]):
            return True
    for i in range(s, s + n):
        begins = i == s or segments[i, 0] != segments[i - 1, 2] or segments[i, 1] != segments[i - 1, 3]
        if begins and contains_point(area, sa, na, segments[i, 0], segments[i, 1]):
            return True
    return False


@kernel
def disc_disc_distance(disc_a: Floats, da: int, ma: int, disc_b: Floats, db: int, mb: int, best: float) -> float:
    """Return the smallest distance [m] between discs of a and b that do not touch, or ``best`` if that is smaller."""
    for i in range(da, da + ma):
        for j in range(db, db + mb):
            dx, dy = disc_a[i, 0] - disc_b[j, 0], disc_a[i, 1] - disc_b[j, 1]
            best = min(best, np.sqrt(dx * dx + dy * dy) - (disc_a[i, 2] + disc_b[j, 2]))
    return best


@kernel
def disc_segment_distance(discs: Floats, d: int, m: int, segments: Floats, s: int, n: int, best: float) -> float:
    """Return the smallest distance [m] between discs and segments that do not touch, or ``best`` if smaller."""
    for i in range(d, d + m):
        x, y, radius = discs[i, 0], discs[i, 1], discs[i, 2]
        least2 = np.inf
        for j in range(s, s + n):
            ax, ay, bx, by = segments[j, 0], segments[j, 1], segments[j, 2], segments[j, 3]
            least2 = min(least2, point_segment_distance2(x, y, ax, ay, bx, by))
        best = min(best, np.sqrt(least2) - radius)
    return best
