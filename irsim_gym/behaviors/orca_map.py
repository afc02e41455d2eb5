"""Half-planes of velocities that avoid the walls of an occupancy map."""

from __future__ import annotations

from irsim_gym.arraytypes import Records
from irsim_gym.behaviors.orca_neighbors import OrcaObstacles, put_in_order
from irsim_gym.behaviors.orca_walls import add_edge, see_edge
from irsim_gym.behaviors.surroundings import Ego, map_walls
from irsim_gym.geometry.segments import point_segment_distance2
from irsim_gym.jit import kernel
from irsim_gym.world.model import WorldModel

SIGHT = 3.0
"""Walls of a map are seen up to here [m]: it has very many, and far ones matter later."""


@kernel
def add_map(
    model: WorldModel,
    w: int,
    ego: Ego,
    horizon: float,
    within: float,
    obstacles: OrcaObstacles,
    planes: Records,
    count: int,
) -> int:
    """Append the half-planes of the map's walls to ``planes``, nearest first; return how many those are now.

    Each wall stands for itself, without its neighbours.

    Reads: model (map_frame, map_squares), obstacles (sides, sides_gap, sides_order).
    Writes: obstacles (sides, sides_gap, sides_order).

    Args:
        model: The map.
        w: The world.
        ego: The body that decides.
        horizon: Collisions later than this are ignored [s].
        within: Walls this far away or farther are left out [m].
        obstacles: ``sides`` and what is known of them are written.
        planes: Half-planes.
        count: Number of rows in use.
    """
    x, y, sides, order, gap2 = ego.x, ego.y, obstacles.sides, obstacles.sides_order, obstacles.sides_gap
    n_seen = 0
    for s in range(map_walls(model, w, x, y, within, sides, 0)):
        # Here a wall is seen from its right.
        sides[s, 0], sides[s, 2] = sides[s, 2], sides[s, 0]
        sides[s, 1], sides[s, 3] = sides[s, 3], sides[s, 1]
        distance2 = point_segment_distance2(x, y, sides[s, 0], sides[s, 1], sides[s, 2], sides[s, 3])
        if distance2 < within * within:
            n_seen = put_in_order(s, distance2, order, gap2, n_seen)
    for i in range(n_seen):
        count = add_edge(see_edge(sides, order[i], 1, order[i], True, x, y), ego, horizon, planes, count)
    return count
