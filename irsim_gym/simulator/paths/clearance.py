"""Exact tests whether a disc is free at a point, or on the straight line between two points."""

from typing import NamedTuple

import numpy as np

from irsim_gym.simulator.cell_maps.world_maps import capsule_meets_map, map_distance
from irsim_gym.simulator.geometry.overlap import capsule_meets_outline, point_outline_distance
from irsim_gym.simulator.paths.points import PointMap, capsule_meets_points, points_distance
from irsim_gym.simulator.world.names import Cells, Flags, Model, Point, State, kernel, outline_of, row_of


class Obstacles(NamedTuple):
    """The obstacles in one world.

    Attributes:
        model: Constants of the simulation.
        state: Its present state.
        w: Index of the world.
        blocks: Flags of bodies that are obstacles, shape ``(n_bodies,)``.
        cells: The occupancy maps, whose occupied cells are always obstacles, or None.
        points: Further points that are obstacles, or None.
    """

    model: Model
    state: State
    w: int
    blocks: Flags
    cells: Cells
    points: PointMap | None


@kernel
def mark_standing(model: Model, w: int, body: int, blocks: Flags) -> None:
    """Write which other bodies are obstacles for a body because they never move.

    Reads: model (present, stands, unobstructed).
    Writes: blocks.
    """
    for b in range(blocks.shape[0]):
        blocks[b] = model.present[w, b] and model.stands[b] and not model.unobstructed[b] and b != body


@kernel
def way_is_free(obstacles: Obstacles, radius: float, start: Point, end: Point) -> bool:
    """Return whether a body can go straight between two points, which may be the same, without touching an obstacle.

    Reads: obstacles (blocks, cells, model, state, w).

    Args:
        obstacles: What is in the way.
        radius: Radius of the moving body [m].
        start: Where it starts [m].
        end: Where it ends [m].
    """
    ax, ay, bx, by = start[0], start[1], end[0], end[1]
    for b in range(obstacles.blocks.shape[0]):
        if not obstacles.blocks[b]:
            continue
        outline = outline_of(obstacles.model, obstacles.state, obstacles.w, b)
        if capsule_meets_outline(start, end, radius, outline):
            return False
    if capsule_meets_map(obstacles.cells, obstacles.w, ax, ay, bx, by, radius):
        return False
    return not capsule_meets_points(obstacles.points, ax, ay, bx, by, radius)


@kernel
def room_at(obstacles: Obstacles, point: Point, limit: float) -> float:
    """Return the distance [m] of a point from the obstacles, 0 inside one, ``limit`` if none is nearer.

    Reads: obstacles (blocks, cells, model, state, w).
    """
    x, y = point
    model, pose, w, best = obstacles.model, obstacles.state.pose[obstacles.w], obstacles.w, limit
    for b in range(obstacles.blocks.shape[0]):
        if not obstacles.blocks[b]:
            continue
        # Bodies that reach no nearer than the best so far are left out.
        dx, dy, far = pose[b, 0] - x, pose[b, 1] - y, model.reach[row_of(model.reach, w), b] + best
        if dx * dx + dy * dy < far * far:
            best = min(best, point_outline_distance(point, outline_of(model, obstacles.state, w, b)))
    best = points_distance(obstacles.points, point, map_distance(obstacles.cells, w, point, best))
    return float(np.maximum(best, 0.0))
