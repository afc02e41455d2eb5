"""Half-planes of velocities that avoid a disc (van den Berg, Guy, Lin, Manocha 2011, sections 4 and 5).

A half-plane is a row (normal x, normal y, least): it permits the velocities v with normal . v >= least.
"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.jit import kernel

LANES = 16
"""So many discs are treated in one go: a loop of fixed length without branches becomes vector instructions."""

LANE_ROWS = 8


@kernel
def disc_plane(
    x: float,
    y: float,
    vx: float,
    vy: float,
    other_vx: float,
    other_vy: float,
    radius: float,
    horizon: float,
    share: float,
    side: float,
    plane: Floats,
) -> None:
    """Write the half-plane of velocities that avoid a disc within some time.

    The relative velocities that lead to a collision form a cone cut off by a disc: the velocity obstacle. ``u`` is the
    least change that takes the relative velocity to its border, where the outward normal is n; ORCA asks of the body
    that it makes a share of this change: n . v >= n . v_now + share n . u.

    Args:
        x: Where the other disc is, relative to the body [m].
        y: Where the other disc is, relative to the body [m].
        vx: The body's velocity [m/s].
        vy: The body's velocity [m/s].
        other_vx: The other's velocity [m/s].
        other_vy: The other's velocity [m/s].
        radius: Sum of both radii [m]. Discs that overlap already: see ``horizon``.
        horizon: Collisions later than this are ignored [s]; for discs that overlap, the time to part them in.
        share: Part of the change that falls to the body: 0.5 among equals, 1 where the other does not give way.
        side: 1 or -1, the other sign for the other body: which way along x to part from the same place and velocity.
        plane: Written, shape ``(3,)``.
    """
    wx, wy = vx - other_vx, vy - other_vy
    distance2 = x * x + y * y
    cut_x, cut_y = wx - x / horizon, wy - y / horizon
    ahead = cut_x * x + cut_y * y
    cut2 = cut_x * cut_x + cut_y * cut_y
    overlap = distance2 <= radius * radius
    if overlap or (ahead < 0.0 and ahead * ahead > radius * radius * cut2):
        length = np.sqrt(cut2)
        nx, ny = away(cut_x, cut_y, length, x, y)
        if length == 0.0 and distance2 == 0.0:
            nx = side
        change = radius / horizon - length
    else:
        leg = np.sqrt(distance2 - radius * radius)
        if x * cut_y - y * cut_x > 0.0:
            nx, ny = -(x * radius + y * leg) / distance2, (x * leg - y * radius) / distance2
        else:
            nx, ny = -(x * radius - y * leg) / distance2, -(x * leg + y * radius) / distance2
        change = -(wx * nx + wy * ny)
    plane[0], plane[1], plane[2] = nx, ny, nx * vx + ny * vy + share * change


@kernel
def away(dx: float, dy: float, length: float, x: float, y: float) -> tuple[float, float]:
    """Return the unit vector along (dx, dy); without a length, that away from (x, y), and without either, +x."""
    if length > 0.0:
        return dx / length, dy / length
    distance = np.sqrt(x * x + y * y)
    if distance > 0.0:
        return -x / distance, -y / distance
    return 1.0, 0.0


@kernel
def disc_planes(vx: float, vy: float, step_time: float, horizon: float, share: float, lanes: Floats) -> None:
    """Write the half-planes of ``disc_plane`` for LANES discs side by side, bit for bit the same.

    Discs that overlap are parted in one step. Where a velocity is the very centre of the cut-off disc, which leaves no
    direction, the half-plane is NaN: that is left to ``disc_plane``.

    Args:
        vx: The body's velocity [m/s].
        vy: The body's velocity [m/s].
        step_time: Duration of a step [s].
        horizon: Collisions later than this are ignored [s].
        share: As in ``disc_plane``.
        lanes: Rows of LANES numbers one after the other. Read: x, y, vx, vy of the others, relative in place, and the
            sum of both radii; written: normal x, normal y, least. Shape ``(LANE_ROWS * LANES,)``.
    """
    for j in range(LANES):
        x, y, radius = lanes[j], lanes[LANES + j], lanes[4 * LANES + j]
        wx, wy = vx - lanes[2 * LANES + j], vy - lanes[3 * LANES + j]
        distance2 = x * x + y * y
        overlap = distance2 <= radius * radius
        time = step_time if overlap else horizon
        cut_x, cut_y = wx - x / time, wy - y / time
        ahead = cut_x * x + cut_y * y
        cut2 = cut_x * cut_x + cut_y * cut_y
        is_round = overlap | ((ahead < 0.0) & (ahead * ahead > radius * radius * cut2))
        length, leg = np.sqrt(cut2), np.sqrt(distance2 - radius * radius)
        is_left = x * cut_y - y * cut_x > 0.0
        leg_x = -(x * radius + y * leg) if is_left else -(x * radius - y * leg)
        leg_y = x * leg - y * radius if is_left else -(x * leg + y * radius)
        divisor = length if is_round else distance2
        nx, ny = (cut_x if is_round else leg_x) / divisor, (cut_y if is_round else leg_y) / divisor
        change = radius / time - length if is_round else -(wx * nx + wy * ny)
        lanes[5 * LANES + j], lanes[6 * LANES + j] = nx, ny
        lanes[7 * LANES + j] = nx * vx + ny * vy + share * change
