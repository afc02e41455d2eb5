"""Exact tests: may a body of some radius stand at a point, or go straight between two?"""

from __future__ import annotations

from typing import NamedTuple

from irsim_gym.arraytypes import CellMaps, Flags
from irsim_gym.geometry.polygons import holds_point
from irsim_gym.geometry.segments import gap2, point_segment_distance2, segment_segment_distance2
from irsim_gym.geometry.world_maps import capsule_meets_map
from irsim_gym.jit import kernel
from irsim_gym.world.model import WorldModel
from irsim_gym.world.outline import outline_of
from irsim_gym.world.state import WorldState

Point = tuple[float, float]


class Obstacles(NamedTuple):
    """What is in the way in one world.

    Attributes:
        model: The constants.
        state: The moment.
        w: Which world.
        blocks: Bodies that are in the way, shape ``(n_bodies,)``.
        cells: The occupancy maps, whose occupied cells are always in the way, or None.
    """

    model: WorldModel
    state: WorldState
    w: int
    blocks: Flags
    cells: CellMaps | None


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
            if gap2(ax, ay, bx, by, cx, cy, dx, dy) > radius2:
                continue
            if segment_segment_distance2(ax, ay, bx, by, cx, cy, dx, dy) <= radius2:
                return False
        if outline.solid and holds_point(outline, ax, ay):
            return False
    return not capsule_meets_map(obstacles.cells, obstacles.w, ax, ay, bx, by, radius)
