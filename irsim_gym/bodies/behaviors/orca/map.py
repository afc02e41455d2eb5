"""Half-planes of velocities that avoid an occupancy map: the walls of its cells, or the discs in them."""

import numpy as np

from irsim_gym.bodies.behaviors.orca.lines import standing_plane
from irsim_gym.bodies.behaviors.orca.neighbors import OrcaObstacles, put_in_order
from irsim_gym.bodies.behaviors.orca.walls import add_edge, see_edge
from irsim_gym.bodies.behaviors.shared.map_parts import map_discs, map_walls
from irsim_gym.bodies.behaviors.shared.surroundings import Ego
from irsim_gym.simulator.geometry.segments import point_segment_distance2
from irsim_gym.simulator.world.names import Model, Records, kernel

SIGHT = 3.0
"""Range of view for maps [m], which have many walls or discs, of which distant ones matter only later."""


@kernel
def add_map(
    model: Model, w: int, ego: Ego, horizon: float, within: float, obstacles: OrcaObstacles, planes: Records, count: int
) -> int:
    """Append the half-planes of the map's walls or discs to ``planes``, nearest first; return how many those are now.

    Each wall stands for itself, without its neighbours.

    Reads: model (map_disc, map_frame, map_squares), obstacles (map_discs, map_gap, map_order, sides).
    Writes: obstacles (map_discs, map_gap, map_order, sides).

    Args:
        model: The map.
        w: World.
        ego: The body that decides.
        horizon: Collisions later than this are ignored [s].
        within: Walls and discs this far away or farther are left out [m].
        obstacles: ``sides``, ``map_discs`` and what is known of them are written.
        planes: Half-planes.
        count: Number of rows in use.
    """
    order = obstacles.map_order
    for i in range(near_walls(model, w, ego, within, obstacles)):
        # An outline of one row: the wall has no neighbours. It is solid, so it is seen from its free side only.
        count = add_edge(
            see_edge(obstacles.sides, order[i], 1, order[i], True, ego.x, ego.y), ego, horizon, planes, count
        )
    for i in range(near_discs(model, w, ego, within, obstacles)):
        standing_plane(ego, obstacles.map_discs[order[i]], horizon, planes[count])
        count += 1
    return count


@kernel
def near_walls(model: Model, w: int, ego: Ego, within: float, obstacles: OrcaObstacles) -> int:
    """Write the walls of the map that are nearer than ``within`` [m], and their order; return their number.

    Reads: model (map_disc, map_frame, map_squares), obstacles (map_gap, map_order, sides).
    Writes: obstacles (map_gap, map_order, sides).
    """
    x, y, sides, n_seen = ego.x, ego.y, obstacles.sides, 0
    for s in range(map_walls(model, w, x, y, within, sides, 0)):
        # map_walls has the free cells to the left of a wall; see_edge expects them to the right.
        sides[s, 0], sides[s, 2] = sides[s, 2], sides[s, 0]
        sides[s, 1], sides[s, 3] = sides[s, 3], sides[s, 1]
        distance2 = point_segment_distance2(x, y, sides[s, 0], sides[s, 1], sides[s, 2], sides[s, 3])
        if distance2 < within * within:
            n_seen = put_in_order(s, distance2, obstacles.map_order, obstacles.map_gap, n_seen)
    return n_seen


@kernel
def near_discs(model: Model, w: int, ego: Ego, within: float, obstacles: OrcaObstacles) -> int:
    """Write the discs of the map that are nearer than ``within`` [m], and their order; return their number.

    Reads: model (map_disc, map_frame, map_squares), obstacles (map_discs, map_gap, map_order).
    Writes: obstacles (map_discs, map_gap, map_order).
    """
    discs, n_seen = obstacles.map_discs, 0
    # map_discs measures to centres, `within` is to edges.
    for d in range(map_discs(model, w, ego.x, ego.y, within + model.map_disc[0], discs)):
        dx, dy = discs[d, 0] - ego.x, discs[d, 1] - ego.y
        gap = max(np.sqrt(dx * dx + dy * dy) - discs[d, 2], 0.0)
        if gap < within:
            n_seen = put_in_order(d, gap * gap, obstacles.map_order, obstacles.map_gap, n_seen)
    return n_seen
