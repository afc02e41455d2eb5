"""From a body's own frame to the world's."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.jit import kernel


@kernel(inlined=True)
def place_outline(
    local_segments: Floats,
    local_discs: Floats,
    segment_start: int,
    segment_count: int,
    disc_start: int,
    disc_count: int,
    x: float,
    y: float,
    heading: float,
    segments: Floats,
    discs: Floats,
) -> None:
    """Write the outline of one body at a pose.

    A vertex that two segments share in the body frame is shared bit for bit in the world frame.

    Args:
        local_segments: x0, y0, x1, y1 in the body frame [m], shape ``(segment, 4)``.
        local_discs: x, y, radius in the body frame [m], shape ``(disc, 3)``.
        segment_start: First of the body's rows of both segment tables.
        segment_count: Number of its segments.
        disc_start: First of the body's rows of both disc tables.
        disc_count: Number of its discs.
        x: Position [m].
        y: Position [m].
        heading: Direction of the body's x axis [rad].
        segments: Written: the same rows in the world frame [m], shape ``(segment, 4)``.
        discs: Written: the same rows in the world frame [m], shape ``(disc, 3)``.
    """
    is_turned = segment_count > 0
    for d in range(disc_start, disc_start + disc_count):
        is_turned = is_turned or local_discs[d, 0] != 0.0 or local_discs[d, 1] != 0.0
    cosine, sine = (np.cos(heading), np.sin(heading)) if is_turned else (1.0, 0.0)
    for s in range(segment_start, segment_start + segment_count):
        ax, ay, bx, by = local_segments[s, 0], local_segments[s, 1], local_segments[s, 2], local_segments[s, 3]
        segments[s, 0] = x + (cosine * ax - sine * ay)
        segments[s, 1] = y + (sine * ax + cosine * ay)
        segments[s, 2] = x + (cosine * bx - sine * by)
        segments[s, 3] = y + (sine * bx + cosine * by)
    for d in range(disc_start, disc_start + disc_count):
        cx, cy = local_discs[d, 0], local_discs[d, 1]
        discs[d, 0] = x + (cosine * cx - sine * cy)
        discs[d, 1] = y + (sine * cx + cosine * cy)
        discs[d, 2] = local_discs[d, 2]
