"""Points and segments: distances and intersection. A segment contains both its ends."""

from irsim_gym.base.kernels import kernel


@kernel(inlined=True)
def point_segment_distance2(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Return the squared distance [m2] of a point from the segment ab, which may be a single point."""
    dx, dy = bx - ax, by - ay
    x, y = px - ax, py - ay
    length2 = dx * dx + dy * dy
    along = x * dx + y * dy
    # The nearest point is b, or the foot of the perpendicular, or a (``along`` <= 0).
    if along >= length2:
        x, y = px - bx, py - by
    elif along > 0.0:
        share = along / length2
        x, y = x - share * dx, y - share * dy
    return x * x + y * y


@kernel
def side(ax: float, ay: float, bx: float, by: float, px: float, py: float) -> float:
    """Return twice the area [m2] of the triangle abp: positive if p lies to the left of the line from a to b."""
    return (bx - ax) * (py - ay) - (by - ay) * (px - ax)


@kernel
def gap2(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float) -> float:
    """Return the squared distance [m2] between the upright boxes around ab and cd: a lower bound of theirs."""
    gap_x = max(min(ax, bx) - max(cx, dx), min(cx, dx) - max(ax, bx), 0.0)
    gap_y = max(min(ay, by) - max(cy, dy), min(cy, dy) - max(ay, by), 0.0)
    return gap_x * gap_x + gap_y * gap_y


@kernel
def segments_intersect(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float) -> bool:
    """Return whether ab and cd have a point in common; touching and collinear overlap count.

    Two closed segments meet exactly if the boxes around them do and neither lies strictly on one side of the
    other's line (for collinear ones the boxes decide).
    """
    if max(ax, bx) < min(cx, dx) or max(cx, dx) < min(ax, bx):
        return False
    if max(ay, by) < min(cy, dy) or max(cy, dy) < min(ay, by):
        return False
    side_c, side_d = side(ax, ay, bx, by, cx, cy), side(ax, ay, bx, by, dx, dy)
    if (side_c > 0.0 and side_d > 0.0) or (side_c < 0.0 and side_d < 0.0):
        return False
    side_a, side_b = side(cx, cy, dx, dy, ax, ay), side(cx, cy, dx, dy, bx, by)
    return not ((side_a > 0.0 and side_b > 0.0) or (side_a < 0.0 and side_b < 0.0))


@kernel
def segment_segment_distance2(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float
) -> float:
    """Return the squared distance [m2] between the segments ab and cd; 0 when they meet."""
    if segments_intersect(ax, ay, bx, by, cx, cy, dx, dy):
        return 0.0
    # Segments that do not meet are nearest to each other at an end of one of them.
    return min(
        point_segment_distance2(ax, ay, cx, cy, dx, dy),
        point_segment_distance2(bx, by, cx, cy, dx, dy),
        point_segment_distance2(cx, cy, ax, ay, bx, by),
        point_segment_distance2(dx, dy, ax, ay, bx, by),
    )
