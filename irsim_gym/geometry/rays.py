"""Rays in the inverse-depth form: what a beam meets, as 1 / distance.

On the line through a and b the inverse depth 1/t of a beam with unit direction d is linear in d, so that a segment
costs three small dot products per beam, without a division or a branch. All arrays are float32 and in the sensor's
own frame; ``inverse`` is raised to the nearest hit, so several primitives can be cast one after the other, and is
inverted once at the end. A beam that meets nothing keeps its value.

The results differ from those in float64 by some 1e-6 of the distance; a beam that grazes an end or an edge seen at
an angle of less than ``EDGE_ON`` may hit or miss either way.
"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Rays
from irsim_gym.jit import kernel

EDGE_ON = 2e-6
"""Segments that subtend an angle smaller than this (or within it of pi) at the sensor are seen edge-on [rad]."""

SLACK = 5e-7
"""A segment is widened by this angle at both ends [rad], so that no beam slips between two that share a vertex."""

HERE = np.float32(1e30)
"""Inverse depth of what touches the sensor [1/m]."""


@kernel(contract=True)
def inverse_depth_segment(
    ax: float, ay: float, bx: float, by: float, beams_x: Rays, beams_y: Rays, inverse: Rays
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
    cross = np.float64(ax) * np.float64(by) - np.float64(ay) * np.float64(bx)
    if cross < 0.0:
        ax, ay, bx, by, cross = bx, by, ax, ay, -cross
    a2 = np.float64(ax) * np.float64(ax) + np.float64(ay) * np.float64(ay)
    b2 = np.float64(bx) * np.float64(bx) + np.float64(by) * np.float64(by)
    if cross * cross <= EDGE_ON * EDGE_ON * a2 * b2:
        if ax * bx + ay * by > np.float32(0.0):
            inverse_depth_point(ax if a2 < b2 else bx, ay if a2 < b2 else by, beams_x, beams_y, inverse)
        else:
            for i in range(inverse.shape[0]):
                inverse[i] = HERE
        return
    normal_x = np.float32((np.float64(by) - np.float64(ay)) / cross)
    normal_y = np.float32((np.float64(ax) - np.float64(bx)) / cross)
    slack_a, slack_b = np.float32(SLACK * np.sqrt(a2)), np.float32(SLACK * np.sqrt(b2))
    for i in range(inverse.shape[0]):
        x, y = beams_x[i], beams_y[i]
        after_a = slack_a + ax * y - ay * x
        before_b = slack_b + by * x - bx * y
        depth = normal_x * x + normal_y * y
        inner = after_a if after_a < before_b else before_b
        depth = depth if inner >= np.float32(0.0) else np.float32(0.0)
        inverse[i] = depth if depth > inverse[i] else inverse[i]


@kernel(contract=True)
def inverse_depth_point(px: float, py: float, beams_x: Rays, beams_y: Rays, inverse: Rays) -> None:
    """Raise ``inverse`` where beams meet the point p, which is as wide as the angles ``EDGE_ON`` and ``SLACK``."""
    distance = np.sqrt(np.float64(px) * np.float64(px) + np.float64(py) * np.float64(py))
    nearest = np.float32(1.0 / distance)
    slack = np.float32((EDGE_ON + SLACK) * distance)
    for i in range(inverse.shape[0]):
        x, y = beams_x[i], beams_y[i]
        ahead = px * x + py * y
        aside = np.abs(px * y - py * x)
        meets = ahead > np.float32(0.0) and aside <= slack
        depth = nearest if meets else np.float32(0.0)
        inverse[i] = depth if depth > inverse[i] else inverse[i]


@kernel(contract=True)
def inverse_depth_disc(cx: float, cy: float, radius: float, beams_x: Rays, beams_y: Rays, inverse: Rays) -> None:
    """Raise ``inverse`` where beams meet a disc: at its near side, or at the exit for a sensor inside.

    Args:
        cx: Centre in the sensor frame [m], float32.
        cy: Centre in the sensor frame [m], float32.
        radius: Radius [m], float32.
        beams_x: Unit directions in the sensor frame, shape ``(n_padded,)``, a multiple of 16.
        beams_y: As ``beams_x``.
        inverse: Raised: inverse depth of the nearest hit [1/m], shape ``(n_padded,)``.
    """
    power = np.float64(cx) * np.float64(cx) + np.float64(cy) * np.float64(cy) - np.float64(radius) * np.float64(radius)
    zero, radius2 = np.float32(0.0), radius * radius
    if power < 0.0:
        for i in range(inverse.shape[0]):
            x, y = beams_x[i], beams_y[i]
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
        depth = (ahead + np.sqrt(room if room > zero else zero)) * scale
        inner = room if room < ahead else ahead
        depth = depth if inner >= zero else zero
        inverse[i] = depth if depth > inverse[i] else inverse[i]
