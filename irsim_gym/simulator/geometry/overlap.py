"""Overlap of and distance between outlines.

The segments of a solid outline are the boundary of an area, those of another are curves; a disc is an area. All sets
are closed: touching is overlapping.
"""

import numpy as np

from irsim_gym.base.arraytypes import BodyOutline, Point
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.geometry.polygons import holds_point
from irsim_gym.simulator.geometry.segments import (
    gap2,
    point_segment_distance2,
    segment_segment_distance2,
    segments_intersect,
)

SURE = 1e-6
"""Margin by which the line of a segment must be too far away to be skipped [m]. Rounding errors are far smaller."""


@kernel
def outlines_overlap(a: BodyOutline, b: BodyOutline) -> bool:
    """Return whether two outlines have a point in common."""
    if discs_overlap(a, b) or discs_meet_segments(a, b) or discs_meet_segments(b, a):
        return True
    for s in range(a.first_segment, a.first_segment + a.n_segments):
        ax, ay, bx, by = a.segments[s, 0], a.segments[s, 1], a.segments[s, 2], a.segments[s, 3]
        for q in range(b.first_segment, b.first_segment + b.n_segments):
            cx, cy, dx, dy = b.segments[q, 0], b.segments[q, 1], b.segments[q, 2], b.segments[q, 3]
            if segments_intersect(ax, ay, bx, by, cx, cy, dx, dy):
                return True
    return (a.solid and holds_part(a, b)) or (b.solid and holds_part(b, a))


@kernel
def outline_distance(a: BodyOutline, b: BodyOutline, limit: float) -> float:
    """Return the distance [m] between two outlines: 0 when they overlap, ``limit`` (may be inf) if not smaller."""
    if outlines_overlap(a, b):
        return 0.0
    # From here on nothing touches.
    best = disc_disc_distance(a, b, limit)
    best = disc_segment_distance(a, b, best)
    best = disc_segment_distance(b, a, best)
    best2 = best * best
    inside = False
    for s in range(a.first_segment, a.first_segment + a.n_segments):
        ax, ay, bx, by = a.segments[s, 0], a.segments[s, 1], a.segments[s, 2], a.segments[s, 3]
        for q in range(b.first_segment, b.first_segment + b.n_segments):
            cx, cy, dx, dy = b.segments[q, 0], b.segments[q, 1], b.segments[q, 2], b.segments[q, 3]
            # The boxes around both segments give a lower bound, far cheaper than the exact distance.
            if gap2(ax, ay, bx, by, cx, cy, dx, dy) < best2:
                distance2 = segment_segment_distance2(ax, ay, bx, by, cx, cy, dx, dy)
                if distance2 < best2:
                    best2, inside = distance2, True
    return float(np.sqrt(best2)) if inside else best


@kernel
def is_round(outline: BodyOutline) -> bool:
    """Return whether an outline is a single disc about the origin."""
    if outline.n_segments != 0 or outline.n_discs != 1:
        return False
    return bool(outline.discs[outline.first_disc, 0] == 0.0 and outline.discs[outline.first_disc, 1] == 0.0)


@kernel
def point_outline_distance(point: Point, outline: BodyOutline) -> float:
    """Return the distance [m] of a point [m] from an outline: 0 inside an area, inf if the outline is empty."""
    if outline.solid and holds_point(outline, point):
        return 0.0
    x, y = point
    best2, segments, discs = np.inf, outline.segments, outline.discs
    for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
        ax, ay, bx, by = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
        best2 = min(best2, point_segment_distance2(x, y, ax, ay, bx, by))
    best = np.sqrt(best2)
    for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
        dx, dy = discs[d, 0] - x, discs[d, 1] - y
        best = min(best, max(np.sqrt(dx * dx + dy * dy) - discs[d, 2], 0.0))
    return float(best)


@kernel(inlined=True)
def disc_meets_outline(centre: Point, radius: float, outline: BodyOutline) -> bool:
    """Return what ``outlines_overlap`` returns for a disc [m] and an outline, in fewer steps."""
    x, y = centre
    segments, discs = outline.segments, outline.discs
    for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
        dx, dy, both = x - discs[d, 0], y - discs[d, 1], radius + discs[d, 2]
        if dx * dx + dy * dy <= both * both:
            return True
    radius2, out2 = radius * radius, (radius + SURE) * (radius + SURE)
    for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
        ax, ay, bx, by = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
        # Whatever is farther from the line is farther from the segment.
        is_out = line_is_out(x, y, ax, ay, bx, by, out2)
        if not is_out and point_segment_distance2(x, y, ax, ay, bx, by) <= radius2:
            return True
    return outline.solid and holds_point(outline, centre)


@kernel(inlined=True)
def capsule_meets_outline(start: Point, end: Point, radius: float, outline: BodyOutline) -> bool:
    """Return whether a disc [m] touches an outline somewhere on the straight way between two points [m]."""
    ax, ay, bx, by = start[0], start[1], end[0], end[1]
    segments, discs, radius2 = outline.segments, outline.discs, radius * radius
    for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
        reach = radius + discs[d, 2]
        if point_segment_distance2(discs[d, 0], discs[d, 1], ax, ay, bx, by) <= reach * reach:
            return True
    for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
        cx, cy, dx, dy = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
        # The boxes around both are a cheaper lower bound.
        if gap2(ax, ay, bx, by, cx, cy, dx, dy) > radius2:
            continue
        if segment_segment_distance2(ax, ay, bx, by, cx, cy, dx, dy) <= radius2:
            return True
    # If no side comes near, the whole way is inside of the area or outside: its start decides.
    return outline.solid and holds_point(outline, start)


@kernel(inlined=True)
def line_is_out(x: float, y: float, ax: float, ay: float, bx: float, by: float, out2: float) -> bool:
    """Return whether the line through a and b lies farther from a point than the root of ``out2`` [m2]."""
    dx, dy = bx - ax, by - ay
    # Distance from the line times the segment's length.
    across = (x - ax) * dy - (y - ay) * dx
    return across * across > out2 * (dx * dx + dy * dy)


@kernel(inlined=True)
def disc_outline_distance(centre: Point, radius: float, outline: BodyOutline, limit: float) -> float:
    """Return what ``outline_distance`` returns for a disc [m] and an outline, in fewer steps."""
    x, y = centre
    best, segments, discs = limit, outline.segments, outline.discs
    for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
        dx, dy, both = x - discs[d, 0], y - discs[d, 1], radius + discs[d, 2]
        distance2 = dx * dx + dy * dy
        if distance2 <= both * both:
            return 0.0
        best = min(best, np.sqrt(distance2) - both)
    if outline.n_segments == 0:
        return best
    # Segments whose lines are farther than the best distance so far cannot improve it.
    least2, out2 = np.inf, (best + radius + SURE) * (best + radius + SURE)
    for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
        ax, ay, bx, by = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
        if not line_is_out(x, y, ax, ay, bx, by, out2):
            least2 = min(least2, point_segment_distance2(x, y, ax, ay, bx, by))
    if least2 <= radius * radius or (outline.solid and holds_point(outline, centre)):
        return 0.0
    return float(min(best, np.sqrt(least2) - radius))


@kernel
def discs_overlap(a: BodyOutline, b: BodyOutline) -> bool:
    """Return whether a disc of a touches a disc of b."""
    for i in range(a.first_disc, a.first_disc + a.n_discs):
        for j in range(b.first_disc, b.first_disc + b.n_discs):
            dx, dy = a.discs[i, 0] - b.discs[j, 0], a.discs[i, 1] - b.discs[j, 1]
            radius = a.discs[i, 2] + b.discs[j, 2]
            if dx * dx + dy * dy <= radius * radius:
                return True
    return False


@kernel
def discs_meet_segments(a: BodyOutline, b: BodyOutline) -> bool:
    """Return whether a disc of a touches a segment of b."""
    discs, segments = a.discs, b.segments
    for i in range(a.first_disc, a.first_disc + a.n_discs):
        x, y, radius2 = discs[i, 0], discs[i, 1], discs[i, 2] * discs[i, 2]
        for j in range(b.first_segment, b.first_segment + b.n_segments):
            ax, ay, bx, by = segments[j, 0], segments[j, 1], segments[j, 2], segments[j, 3]
            if point_segment_distance2(x, y, ax, ay, bx, by) <= radius2:
                return True
    return False


@kernel
def holds_part(area: BodyOutline, other: BodyOutline) -> bool:
    """Return whether an area holds a disc's centre or the first point of a chain of another outline.

    Where no boundaries cross, a chain lies wholly inside or outside, so one point of each is enough.
    """
    segments, first = other.segments, other.first_segment
    for d in range(other.first_disc, other.first_disc + other.n_discs):
        if holds_point(area, (other.discs[d, 0], other.discs[d, 1])):
            return True
    for s in range(first, first + other.n_segments):
        begins = s == first or segments[s, 0] != segments[s - 1, 2] or segments[s, 1] != segments[s - 1, 3]
        if begins and holds_point(area, (segments[s, 0], segments[s, 1])):
            return True
    return False


@kernel
def disc_disc_distance(a: BodyOutline, b: BodyOutline, best: float) -> float:
    """Return the smallest distance [m] between discs of a and b that do not touch, or ``best`` if that is smaller."""
    for i in range(a.first_disc, a.first_disc + a.n_discs):
        for j in range(b.first_disc, b.first_disc + b.n_discs):
            dx, dy = a.discs[i, 0] - b.discs[j, 0], a.discs[i, 1] - b.discs[j, 1]
            best = min(best, np.sqrt(dx * dx + dy * dy) - (a.discs[i, 2] + b.discs[j, 2]))
    return best


@kernel
def disc_segment_distance(a: BodyOutline, b: BodyOutline, best: float) -> float:
    """Return the smallest distance [m] from a disc of a to a segment of b, or ``best`` if that is smaller."""
    discs, segments = a.discs, b.segments
    for i in range(a.first_disc, a.first_disc + a.n_discs):
        x, y, radius = discs[i, 0], discs[i, 1], discs[i, 2]
        least2 = np.inf
        for j in range(b.first_segment, b.first_segment + b.n_segments):
            ax, ay, bx, by = segments[j, 0], segments[j, 1], segments[j, 2], segments[j, 3]
            least2 = min(least2, point_segment_distance2(x, y, ax, ay, bx, by))
        best = min(best, np.sqrt(least2) - radius)
    return best
