"""Rays in inverse depth: 1 / distance of the nearest hit.

On the line through a and b, the inverse depth 1/t of a beam with unit direction d is linear in d. So a segment costs
three small dot products per beam, without a division or a branch. All arrays are float32 and in the sensor frame.
``inverse`` is raised to the nearest hit, so that several primitives can be cast one after another, and is inverted once
at the end. A beam that meets nothing keeps its value.

Results differ from those in float64 by about 1e-6 of the distance. A beam that grazes an end, or an edge seen at an
angle of less than ``EDGE_ON``, may hit or miss.
"""

import numpy as np

from irsim_gym.base.arraytypes import Rays
from irsim_gym.base.kernels import kernel

EDGE_ON = 2e-6
"""Segments that subtend an angle smaller than this (or within it of pi) at the sensor are seen edge-on [rad]."""

SLACK = np.float32(3e-7)
"""Segments are widened at both ends by this angle [rad] or up to sqrt(2) times as much, so that no beam slips between
two that share a vertex."""

HERE = np.float32(1e30)
"""Inverse depth of a hit at distance 0 [1/m]."""


@kernel(contract=True)
def inverse_depth_segment(
    ax: np.float32, ay: np.float32, bx: np.float32, by: np.float32, beams_x: Rays, beams_y: Rays, inverse: Rays
) -> None:
    """Raise ``inverse`` where beams meet the segment ab, from either side.

    A beam along a segment seen edge-on meets its nearer end; a sensor on the segment meets it with every beam at
    distance 0.

    Args:
        ax: First end in the sensor frame [m], float32.
        ay: First end in the sensor frame [m], float32.
        bx: Second end in the sensor frame [m], float32.
        by: Second end in the sensor frame [m], float32.
        beams_x: Unit directions in the sensor frame, shape ``(n_padded,)``, a multiple of 16.
        beams_y: As ``beams_x``.
        inverse: Raised: inverse depth of the nearest hit [1/m], shape ``(n_padded,)``.
    """
    a_x, a_y, b_x, b_y = np.float64(ax), np.float64(ay), np.float64(bx), np.float64(by)
    a2, b2 = a_x * a_x + a_y * a_y, b_x * b_x + b_y * b_y
    cross = a_x * b_y - a_y * b_x
    slack, level = SLACK, np.float32(0.0)
    normal_x, normal_y = 0.0, 0.0
    # a x b = |a| |b| sin(angle between both ends).
    if cross * cross > EDGE_ON * EDGE_ON * a2 * b2:
        normal_x, normal_y = (b_y - a_y) / cross, (a_x - b_x) / cross
    elif a_x * b_x + a_y * b_y > 0.0:
        # Only the nearer end p is visible, as a segment from p to p: there 1/t = p.d / p.p.
        if a2 < b2:
            bx, by = ax, ay
        else:
            ax, ay = bx, by
        slack = SLACK + np.float32(EDGE_ON)
        normal_x, normal_y = np.float64(ax) / min(a2, b2), np.float64(ay) / min(a2, b2)
    else:
        # The sensor is on the segment: every beam passes the test below, with the depth of a hit at distance 0.
        slack, level = HERE, HERE
    x_slope, y_slope = np.float32(normal_x), np.float32(normal_y)
    # |x| + |y| stands for the distance of an end, and is up to sqrt(2) times as much.
    slack_a, slack_b = slack * (np.abs(ax) + np.abs(ay)), slack * (np.abs(bx) + np.abs(by))
    # Where b lies clockwise of a, both cross products below are negative for the beams in between: this flips them.
    turn = np.float32(1.0) if cross > 0.0 else np.float32(-1.0)
    ax, ay, bx, by = turn * ax, turn * ay, turn * bx, turn * by
    for i in range(inverse.shape[0]):
        x, y = beams_x[i], beams_y[i]
        after_a = slack_a + ax * y - ay * x
        before_b = slack_b + by * x - bx * y
        depth = level + x_slope * x + y_slope * y
        inner = after_a if after_a < before_b else before_b
        depth = depth if inner >= np.float32(0.0) else np.float32(0.0)
        inverse[i] = depth if depth > inverse[i] else inverse[i]


@kernel(contract=True)
def inverse_depth_disc(
    cx: np.float32, cy: np.float32, radius: np.float32, beams_x: Rays, beams_y: Rays, inverse: Rays
) -> None:
    """Raise ``inverse`` where beams meet a disc: at its near side, or at the exit for a sensor inside.

    Args:
        cx: Centre in the sensor frame [m], float32.
        cy: Centre in the sensor frame [m], float32.
        radius: Radius [m], float32.
        beams_x: Unit directions in the sensor frame, shape ``(n_padded,)``, a multiple of 16.
        beams_y: As ``beams_x``.
        inverse: Raised: inverse depth of the nearest hit [1/m], shape ``(n_padded,)``.
    """
    # The sensor's power with respect to the circle: the product of the distances to both crossings, negative inside.
    power = np.float64(cx) * np.float64(cx) + np.float64(cy) * np.float64(cy) - np.float64(radius) * np.float64(radius)
    zero, radius2 = np.float32(0.0), radius * radius
    if power < 0.0:
        for i in range(inverse.shape[0]):
            x, y = beams_x[i], beams_y[i]
            # From inside, the only crossing ahead is the exit, at ``ahead`` + half of the chord.
            aside = cx * y - cy * x
            room = radius2 - aside * aside
            way = cx * x + cy * y + np.sqrt(room if room > zero else zero)
            depth = np.float32(1.0) / (way if way > np.float32(1.0) / HERE else np.float32(1.0) / HERE)
            inverse[i] = depth if depth > inverse[i] else inverse[i]
        return
    scale = np.float32(min(1.0 / power, np.float64(HERE))) if power > 0.0 else HERE
    for i in range(inverse.shape[0]):
        x, y = beams_x[i], beams_y[i]
        ahead = cx * x + cy * y
        aside = cx * y - cy * x
        room = radius2 - aside * aside
        # The nearer crossing is at t = power / (ahead + half chord), because both multiply to the power.
        depth = (ahead + np.sqrt(room if room > zero else zero)) * scale
        # A hit needs both: the line meets the circle (room), and the circle is ahead.
        inner = room if room < ahead else ahead
        depth = depth if inner >= zero else zero
        inverse[i] = depth if depth > inverse[i] else inverse[i]
