"""Half-planes of velocities that avoid the walls of an occupancy map."""

from __future__ import annotations

from irsim_gym.arraytypes import Bytes, Floats, Ints, Record
from irsim_gym.behaviors.orca_neighbors import put_in_order
from irsim_gym.behaviors.orca_walls import is_covered, see_edge, wall_plane
from irsim_gym.behaviors.surroundings import map_walls
from irsim_gym.geometry.segments import point_segment_distance2
from irsim_gym.jit import kernel

SIGHT = 3.0
"""Walls of a map are seen up to here [m]: it has very many, and far ones matter later."""


@kernel
def add_map(
    radius: float,
    horizon: float,
    within: float,
    pose: Floats,
    velocity: Floats,
    frame: Record,
    squares: Bytes,
    sides: Floats,
    gap2: Floats,
    order: Ints,
    edge: Floats,
    planes: Floats,
    count: int,
) -> int:
    """Append the half-planes of the map's walls to ``planes``, nearest first; return how many those are now.

    Each wall stands for itself, without its neighbours.

    Args:
        radius: The body's radius [m].
        horizon: Collisions later than this are ignored [s].
        within: Walls this far away or farther are left out [m].
        pose: x, y, heading of the body [m, m, rad], shape ``(3,)``.
        velocity: Its velocity [m/s], shape ``(2,)``.
        frame: ``model.map_frame[0]``.
        squares: ``model.map_squares``.
        sides: Scratch, shape ``(most, 4)``.
        gap2: Scratch, shape ``(most,)``.
        order: Scratch, shape ``(most,)``.
        edge: Scratch, as ``see_edge`` writes it.
        planes: Half-planes, shape ``(n, 3)``.
        count: Number of rows in use.
    """
    x, y = pose[0], pose[1]
    n_sides = map_walls(x, y, within, frame, squares, sides, 0)
    n_seen = 0
    for s in range(n_sides):
        # Here a wall is seen from its right.
        sides[s, 0], sides[s, 2] = sides[s, 2], sides[s, 0]
        sides[s, 1], sides[s, 3] = sides[s, 3], sides[s, 1]
        distance2 = point_segment_distance2(x, y, sides[s, 0], sides[s, 1], sides[s, 2], sides[s, 3])
        if distance2 < within * within:
            n_seen = put_in_order(s, distance2, order, gap2, n_seen, order.shape[0])
    for i in range(n_seen):
        if see_edge(sides, order[i], 1, order[i], True, x, y, edge):
            covered = is_covered(planes, count, edge[0], edge[1], edge[2], edge[3], radius, horizon)
            if not covered and wall_plane(edge, velocity[0], velocity[1], radius, horizon, planes[count]):
                count += 1
    return count
