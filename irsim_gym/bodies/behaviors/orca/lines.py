"""Half-planes of velocities that avoid a disc (van den Berg, Guy, Lin, Manocha 2011, sections 4 and 5)."""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats, Point, Record, Vector
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import record_type
from irsim_gym.bodies.behaviors.shared.surroundings import Ego
from irsim_gym.simulator.geometry.linear_program import set_plane

HALF, WHOLE = 0.5, 1.0
"""Share of a change of velocity that a body takes: among equals, and if the other body does not yield."""

LANES = 16
"""Number of discs per pass: the compiler turns a loop of fixed length without branches into vector instructions."""

DISC_LANES = record_type("x y vx vy radius nx ny least", LANES)
"""LANES discs, as ``Other`` has them, and the half-planes of velocities that avoid them."""


class Other(NamedTuple):
    """A disc to avoid.

    Attributes:
        x: Its centre, relative to that of the body that decides [m].
        y: Its centre, relative to that of the body that decides [m].
        vx: Its velocity [m/s].
        vy: Its velocity [m/s].
        radius: Sum of both radii [m].
    """

    x: float
    y: float
    vx: float
    vy: float
    radius: float


@kernel
def disc_plane(ego: Ego, other: Other, horizon: float, share: float, side: float, plane: Record) -> None:
    """Write the half-plane of velocities that avoid a disc within some time.

    The relative velocities that lead to a collision form a cone cut off by a disc: the velocity obstacle. ``u`` is the
    least change that takes the relative velocity to its border, where the outward normal is n; ORCA asks of the body
    that it makes a share of this change: n . v >= n . v_now + share n . u.

    Args:
        ego: The body that decides.
        other: The disc. Where both overlap already: see ``horizon``.
        horizon: Collisions later than this are ignored [s]; for discs that overlap, the time to part them in.
        share: Part of the change that falls to the body: 0.5 among equals, 1 where the other does not give way.
        side: 1 or -1, the other sign for the other body: which way along x to part from the same place and velocity.
        plane: Written.
    """
    x, y, radius = other.x, other.y, other.radius
    # The obstacle is that of relative velocities: a disc p / horizon of radius r / horizon, and the cone behind it.
    wx, wy = ego.vx - other.vx, ego.vy - other.vy
    distance2 = x * x + y * y
    # From the centre of the disc that cuts off the cone to the relative velocity.
    cut_x, cut_y = wx - x / horizon, wy - y / horizon
    ahead = cut_x * x + cut_y * y
    cut2 = cut_x * cut_x + cut_y * cut_y
    overlap = distance2 <= radius * radius
    # Nearest to the arc, not to a leg: that is so within the angle arccos(r / d) of the direction back to the apex.
    if overlap or (ahead < 0.0 and ahead * ahead > radius * radius * cut2):
        length = np.sqrt(cut2)
        nx, ny = away((cut_x, cut_y), (x, y))
        # Two bodies at one place with one velocity: nothing but their order tells them apart.
        if length == 0.0 and distance2 == 0.0:
            nx = side
        # n . u, the distance to the border; negative where the velocity is free already.
        change = radius / horizon - length
    else:
        # Legs are the tangents from the apex to the disc, of length sqrt(d^2 - r^2).
        leg = np.sqrt(distance2 - radius * radius)
        # To the left of the axis, the left leg is the nearer one. The normals point out of the cone.
        if x * cut_y - y * cut_x > 0.0:
            nx, ny = -(x * radius + y * leg) / distance2, (x * leg - y * radius) / distance2
        else:
            nx, ny = -(x * radius - y * leg) / distance2, -(x * leg + y * radius) / distance2
        # The legs run through the apex, the relative velocity 0.
        change = -(wx * nx + wy * ny)
    # n . (v - (v_now + share u)) >= 0, with u = change n.
    set_plane(plane, nx, ny, nx * ego.vx + ny * ego.vy + share * change)


@kernel
def standing_plane(ego: Ego, disc: Floats, horizon: float, plane: Record) -> None:
    """Write the half-plane of velocities that avoid a disc that never moves.

    One that is touched already need not be left at once, as a wall need not; only going nearer is forbidden.

    Args:
        ego: The body that decides.
        disc: x, y, radius [m].
        horizon: Collisions later than this are ignored [s].
        plane: Written.
    """
    dx, dy, both = disc[0] - ego.x, disc[1] - ego.y, disc[2] + ego.radius
    gap2 = dx * dx + dy * dy
    if gap2 <= both * both:
        nx, ny = away((-dx, -dy), (dx, dy))
        # Only the direction towards the disc is forbidden; disc_plane would ask for a way out at once.
        set_plane(plane, nx, ny, 0.0)
    else:
        disc_plane(ego, Other(dx, dy, 0.0, 0.0, both), horizon, WHOLE, 1.0, plane)


@kernel
def away(along: Vector, place: Point) -> Vector:
    """Return the unit vector along a vector; without a length, that away from a place, and without either, +x."""
    dx, dy, x, y = along[0], along[1], place[0], place[1]
    length = np.sqrt(dx * dx + dy * dy)
    if length > 0.0:
        return dx / length, dy / length
    distance = np.sqrt(x * x + y * y)
    if distance > 0.0:
        return -x / distance, -y / distance
    return 1.0, 0.0


@kernel
def disc_planes(ego: Ego, step_time: float, horizon: float, share: float, lanes: Record) -> None:
    """Write the half-planes of ``disc_plane`` for LANES discs side by side, bit for bit the same.

    Discs that overlap are parted in one step. Where a velocity is the very centre of the cut-off disc, which leaves no
    direction, the half-plane is NaN: that is left to ``disc_plane``.

    Args:
        ego: The body that decides.
        step_time: Duration of a step [s].
        horizon: Collisions later than this are ignored [s].
        share: As in ``disc_plane``.
        lanes: The discs; their half-planes are written.
    """
    for j in range(LANES):
        x, y, radius = lanes.x[j], lanes.y[j], lanes.radius[j]
        wx, wy = ego.vx - lanes.vx[j], ego.vy - lanes.vy[j]
        distance2 = x * x + y * y
        overlap = distance2 <= radius * radius
        time = step_time if overlap else horizon
        cut_x, cut_y = wx - x / time, wy - y / time
        ahead = cut_x * x + cut_y * y
        cut2 = cut_x * cut_x + cut_y * cut_y
        is_round = overlap | ((ahead < 0.0) & (ahead * ahead > radius * radius * cut2))
        # NaN for discs that overlap, where the leg is not used.
        length, leg = np.sqrt(cut2), np.sqrt(distance2 - radius * radius)
        is_left = x * cut_y - y * cut_x > 0.0
        leg_x = -(x * radius + y * leg) if is_left else -(x * radius - y * leg)
        leg_y = x * leg - y * radius if is_left else -(x * leg + y * radius)
        divisor = length if is_round else distance2
        nx, ny = (cut_x if is_round else leg_x) / divisor, (cut_y if is_round else leg_y) / divisor
        change = radius / time - length if is_round else -(wx * nx + wy * ny)
        lanes.nx[j], lanes.ny[j] = nx, ny
        lanes.least[j] = nx * ego.vx + ny * ego.vy + share * change
