"""Exact tests whether a disc is free at a point, or on the straight line between two points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from irsim_gym.arraytypes import CellMaps, Flags, Point
from irsim_gym.geometry.overlap import point_outline_distance
from irsim_gym.geometry.polygons import holds_point
from irsim_gym.geometry.segments import gap2, point_segment_distance2, segment_segment_distance2
from irsim_gym.geometry.world_maps import capsule_meets_map, map_distance
from irsim_gym.jit import kernel
from irsim_gym.paths.points import PointMap, capsule_meets_points, points_distance
from irsim_gym.world.model import Model
from irsim_gym.world.outline import outline_of
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import State


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
    cells: CellMaps | None
    points: PointMap | None


@kernel
def mark_standing(model: Model, w: int, own: int, blocks: Flags) -> None:
    """Write which other bodies are obstacles for a body because they never move.

    Reads: model (present, stands, unobstructed).
    Writes: blocks.
    """
    for b in range(blocks.shape[0]):
        blocks[b] = model.present[w, b] and model.stands[b] and not model.unobstructed[b] and b != own


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
    blocks, radius2 = obstacles.blocks, radius * radius
    for b in range(blocks.shape[0]):
        if not blocks[b]:
            continue
        outline = outline_of(obstacles.model, obstacles.state, obstacles.w, b)
        segments, discs = outline.segments, outline.discs
        for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
            reach = radius + discs[d, 2]
            if point_segment_distance2(discs[d, 0], discs[d, 1], ax, ay, bx, by) <= reach * reach:
                return False
        for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
            cx, cy, dx, dy = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
            # The boxes around both are a cheaper lower bound.
            if gap2(ax, ay, bx, by, cx, cy, dx, dy) > radius2:
                continue
            if segment_segment_distance2(ax, ay, bx, by, cx, cy, dx, dy) <= radius2:
                return False
        # No side comes near, so the whole way is inside of the area or outside: its start decides.
        if outline.solid and holds_point(outline, start):
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
