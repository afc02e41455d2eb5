"""Half-planes of velocities that avoid walls (van den Berg et al. 2011, section 5: static obstacles).

A wall is a directed edge from a to b that is seen from its right, the outer side of a counter-clockwise outline; a thin
wall is seen from both sides. All points are relative to the observing body.
The velocities that lead to a collision within the horizon are the edge, divided by the horizon and grown by the body's
disc, and all that lies behind it: a blunt cone with a left leg through a, a right leg through b, and a front.
"""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats, Point, Record, Records, Vector
from irsim_gym.base.kernels import kernel
from irsim_gym.bodies.behaviors.orca.lines import away
from irsim_gym.bodies.behaviors.shared.surroundings import Ego
from irsim_gym.simulator.geometry.linear_program import set_plane

ROUNDING = 1e-9
"""Margin with which a half-plane covers an edge [m]."""


class Edge(NamedTuple):
    """An edge as a body sees it.

    Attributes:
        is_seen: Whether its front faces the body; if not, the other fields are unused.
        ax: Its start, relative to the body [m].
        ay: Likewise.
        bx: Its end [m].
        by: Likewise.
        before_x: Unit vector along the edge before it.
        before_y: Likewise.
        along_x: Unit vector along itself.
        along_y: Likewise.
        behind_x: Unit vector along the edge behind it.
        behind_y: Likewise.
    """

    is_seen: bool
    ax: float
    ay: float
    bx: float
    by: float
    before_x: float
    before_y: float
    along_x: float
    along_y: float
    behind_x: float
    behind_y: float


UNSEEN = Edge(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""An edge whose front does not face the body."""


class Front(NamedTuple):
    """The front of a blunt cone.

    Attributes:
        ax: Start of its left leg, relative to the body [m].
        ay: Likewise.
        bx: Start of its right leg [m].
        by: Likewise.
        convex_a: Whether the left leg is a tangent; if not, it runs along the edge.
        convex_b: Whether the right leg is a tangent; if not, it runs along the edge.
        is_point: Whether both legs begin at the same end of the edge.
    """

    ax: float
    ay: float
    bx: float
    by: float
    convex_a: bool
    convex_b: bool
    is_point: bool


@kernel
def see_edge(segments: Floats, start: int, count: int, s: int, solid: bool, x: float, y: float) -> Edge:
    """Return segment s of an outline as it is seen from (x, y).

    Args:
        segments: x0, y0, x1, y1 [m], shape ``(segment, 4)``.
        start: First row of the outline.
        count: Number of its rows.
        s: The row.
        solid: The outline bounds an area, and is seen from outside only.
        x: Position of the body [m].
        y: Position of the body [m].
    """
    ax, ay, bx, by = segments[s, 0] - x, segments[s, 1] - y, segments[s, 2] - x, segments[s, 3] - y
    dx, dy, length = direction(segments, s)
    # The distance of the body from the edge's line, positive to its right.
    height = dx * ay - dy * ax
    if length == 0.0 or height == 0.0 or (height < 0.0 and solid):
        return UNSEEN
    before, behind = neighbour(segments, start, count, s, -1), neighbour(segments, start, count, s, 1)
    ux, uy, _ = direction(segments, before)
    vx, vy, _ = direction(segments, behind)
    # At an open end the outline is taken to turn back along the edge, which makes the end convex.
    if before == s:
        ux, uy = -dx, -dy
    if behind == s:
        vx, vy = -dx, -dy
    if height > 0.0:
        return Edge(True, ax, ay, bx, by, ux, uy, dx, dy, vx, vy)
    # Seen from its left: the edge in the opposite direction, with its neighbours exchanged and reversed as well.
    return Edge(True, bx, by, ax, ay, -vx, -vy, -dx, -dy, -ux, -uy)


@kernel
def direction(segments: Floats, s: int) -> tuple[float, float, float]:
    """Return the unit vector along a segment, and its length [m]."""
    dx, dy = segments[s, 2] - segments[s, 0], segments[s, 3] - segments[s, 1]
    length = np.sqrt(dx * dx + dy * dy)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    return dx / length, dy / length, length


@kernel
def neighbour(segments: Floats, start: int, count: int, s: int, step: int) -> int:
    """Return the row before (step -1) or behind (step 1) a segment in its chain; itself at an open end.

    The rows of a chain follow each other and share their vertices; a closed one ends where it begins.
    """
    k = s + step
    if start <= k < start + count and is_joined(segments, min(k, s), max(k, s)):
        return k
    # The segment ends its chain. Its neighbour is the other end of the chain, if the chain is closed.
    k = s
    while start <= k - step < start + count and is_joined(segments, min(k, k - step), max(k, k - step)):
        k -= step
    first, last = (k, s) if step > 0 else (s, k)
    return k if is_joined(segments, last, first) else s


@kernel
def is_joined(segments: Floats, first: int, other: int) -> bool:
    """Return whether a segment ends where another begins."""
    return bool(segments[first, 2] == segments[other, 0] and segments[first, 3] == segments[other, 1])


@kernel
def add_edge(edge: Edge, ego: Ego, horizon: float, planes: Records, count: int) -> int:
    """Append the half-plane of velocities that avoid an edge, if one is needed; return how many those are now."""
    if not edge.is_seen or is_covered(planes[:count], edge, ego.radius, horizon):
        return count
    return count + int(wall_plane(edge, ego, horizon, planes[count]))


@kernel
def wall_plane(edge: Edge, ego: Ego, horizon: float, plane: Record) -> bool:
    """Write the half-plane of velocities that avoid an edge; return False where the edges beside it see to that.

    Args:
        edge: The edge.
        ego: The body.
        horizon: Collisions later than this are ignored [s].
        plane: Written.
    """
    ax, ay, bx, by, dx, dy = edge.ax, edge.ay, edge.bx, edge.by, edge.along_x, edge.along_y
    # A left turn at a vertex of a counter-clockwise outline is a convex corner.
    convex_a = edge.before_x * dy - edge.before_y * dx >= 0.0
    convex_b = dx * edge.behind_y - dy * edge.behind_x >= 0.0
    # Whether the foot of the perpendicular from the body lies before a or past b, where the end is what is nearest.
    before_a, past_b = ax * dx + ay * dy > 0.0, bx * dx + by * dy < 0.0
    height, radius = dx * ay - dy * ax, ego.radius
    radius2, gap_a2, gap_b2 = radius * radius, ax * ax + ay * ay, bx * bx + by * by
    if before_a and gap_a2 <= radius2:
        nx, ny = away((-ax, -ay), (ax, ay))
        # Touched already: only going nearer is forbidden. A reflex corner is left to the edge before.
        set_plane(plane, nx, ny, 0.0)
        return bool(convex_a)
    if past_b and gap_b2 <= radius2:
        nx, ny = away((-bx, -by), (bx, by))
        # Likewise. If the edge behind faces the body too, the corner is left to it, as its start.
        set_plane(plane, nx, ny, 0.0)
        return bool(convex_b and bx * edge.behind_y - by * edge.behind_x >= 0.0)
    if height <= radius and not before_a and not past_b:
        # The outward normal of the edge, to its right.
        set_plane(plane, dy, -dx, 0.0)
        return True
    if height <= radius:
        # Seen at a flat angle, from beyond an end: that vertex alone stands for the edge.
        if (before_a and not convex_a) or (past_b and not convex_b):
            return False
        x, y = (ax, ay) if before_a else (bx, by)
        return cone_plane(edge, Front(x, y, x, y, True, True, True), ego, horizon, plane)
    return cone_plane(edge, Front(ax, ay, bx, by, convex_a, convex_b, False), ego, horizon, plane)


@kernel
def cone_plane(edge: Edge, front: Front, ego: Ego, horizon: float, plane: Record) -> bool:
    """Write the half-plane at the point of the blunt cone's border that is nearest to the velocity.

    Legs are tangents from the body's centre. At a reflex corner the leg runs along the edge, and one that would run
    into the edge beside it runs along that one; a velocity nearest to such a leg is left to that edge.
    """
    ax, ay, bx, by, convex_a, convex_b, is_point = front
    dx, dy, radius = edge.along_x, edge.along_y, ego.radius
    # At a reflex corner, the leg continues the edge.
    left_x, left_y = tangent(ax, ay, radius, 1.0) if convex_a else (-dx, -dy)
    right_x, right_y = tangent(bx, by, radius, -1.0) if convex_b else (dx, dy)
    # The edges that lead away from both ends of the front, as seen from these.
    back_x, back_y, on_x, on_y = -edge.before_x, -edge.before_y, edge.behind_x, edge.behind_y
    # For a single vertex, the edge itself is one of the two.
    if is_point and ax == edge.bx and ay == edge.by:
        back_x, back_y = -dx, -dy
    elif is_point:
        on_x, on_y = dx, dy
    # A leg that turns into the neighbouring edge is replaced by it ("foreign").
    left_foreign = convex_a and left_x * back_y - left_y * back_x >= 0.0
    right_foreign = convex_b and right_x * on_y - right_y * on_x <= 0.0
    if left_foreign:
        left_x, left_y = back_x, back_y
    if right_foreign:
        right_x, right_y = on_x, on_y
    # Divided by the horizon, distances are velocities. The border lies `grown` outside of the front and the legs.
    grown = radius / horizon
    from_a_x, from_a_y = ego.vx - ax / horizon, ego.vy - ay / horizon
    from_b_x, from_b_y = ego.vx - bx / horizon, ego.vy - by / horizon
    # How far along each leg the velocity lies; negative before its start.
    up_left, up_right = from_a_x * left_x + from_a_y * left_y, from_b_x * right_x + from_b_y * right_y
    before_a = from_a_x * dx + from_a_y * dy < 0.0
    past_b = from_b_x * dx + from_b_y * dy > 0.0
    # Before the legs and beside the front: the border is round there.
    if (is_point and up_left < 0.0 and up_right < 0.0) or (not is_point and before_a and up_left < 0.0):
        return round_plane((ax, ay), (from_a_x, from_a_y), horizon, grown, plane)
    if not is_point and past_b and up_right < 0.0:
        return round_plane((bx, by), (from_b_x, from_b_y), horizon, grown, plane)
    # Distances from the three straight parts of the border. Those beside which the velocity does not lie do not count.
    to_front = from_a_x * dy - from_a_y * dx
    to_left = from_a_x * left_y - from_a_y * left_x
    to_right = from_b_x * right_y - from_b_y * right_x
    far = np.inf
    front2 = far if is_point or before_a or past_b else to_front * to_front
    left2 = far if up_left < 0.0 else to_left * to_left
    right2 = far if up_right < 0.0 else to_right * to_right
    if front2 <= left2 and front2 <= right2:
        # Normals point out of the cone: to the right of the front and of the right leg, to the left of the left leg.
        nx, ny, x, y, mine = dy, -dx, ax, ay, True
    elif left2 <= right2:
        nx, ny, x, y, mine = -left_y, left_x, ax, ay, not left_foreign
    else:
        nx, ny, x, y, mine = right_y, -right_x, bx, by, not right_foreign
    set_plane(plane, nx, ny, (nx * x + ny * y) / horizon + grown)
    return bool(mine)


@kernel
def tangent(x: float, y: float, radius: float, turn: float) -> Vector:
    """Return the direction of the tangent from the origin to a disc around (x, y), on its left (turn 1) or right."""
    gap2 = x * x + y * y
    # Turns the direction to the disc by asin(r / d), whose cosine is leg / d and whose sine is r / d.
    leg, radius = np.sqrt(max(gap2 - radius * radius, 0.0)), turn * radius
    return (x * leg - y * radius) / gap2, (x * radius + y * leg) / gap2


@kernel
def round_plane(centre: Point, off: Vector, horizon: float, grown: float, plane: Record) -> bool:
    """Write the half-plane at the round end of a cone around centre / horizon, in the direction of ``off`` from it."""
    nx, ny = away(off, centre)
    set_plane(plane, nx, ny, (nx * centre[0] + ny * centre[1]) / horizon + grown)
    return True


@kernel
def is_covered(planes: Records, edge: Edge, radius: float, horizon: float) -> bool:
    """Return whether one of the half-planes forbids all velocities that an edge would forbid."""
    for plane in planes:
        # Both ends of the edge, divided by the horizon and grown by the body's disc, lie in the forbidden half-plane.
        least = horizon * plane.least - radius + ROUNDING
        if plane.nx * edge.ax + plane.ny * edge.ay <= least and plane.nx * edge.bx + plane.ny * edge.by <= least:
            return True
    return False
