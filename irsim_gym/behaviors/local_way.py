"""The path that a local planner follows, from where the body stands, in the frame of the body."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.geometry.segments import point_segment_distance2
from irsim_gym.jit import kernel


@kernel
def lay_straight(goal_x: float, goal_y: float, way: Floats) -> int:
    """Write the straight way to a goal [m], and return its number of points.

    Writes: way.
    """
    way[0, 0], way[1, 0], way[0, 1], way[1, 1] = 0.0, 0.0, goal_x, goal_y
    return 2


@kernel
def point_ahead(way: Floats, n_points: int, distance: float) -> tuple[float, float]:
    """Return the point so far ahead on a way [m], its end if that is nearer.

    Args:
        way: x and y of its points [m], shape ``(2, n)``.
        n_points: Number of points.
        distance: Length of the way up to the point [m].
    """
    left = distance
    for i in range(n_points - 1):
        dx, dy = way[0, i + 1] - way[0, i], way[1, i + 1] - way[1, i]
        length = np.sqrt(dx * dx + dy * dy)
        if length >= left and length > 0.0:
            return way[0, i] + dx * (left / length), way[1, i] + dy * (left / length)
        left -= length
    return way[0, n_points - 1], way[1, n_points - 1]


@kernel
def distance_from_way(way: Floats, n_points: int, x: float, y: float) -> float:
    """Return the distance of a point from a way [m]."""
    best2 = np.inf
    for i in range(n_points - 1):
        best2 = min(best2, point_segment_distance2(x, y, way[0, i], way[1, i], way[0, i + 1], way[1, i + 1]))
    return float(np.sqrt(best2))
