"""Exact tests: may a body of some radius stand at a point, or go straight between two?"""

from __future__ import annotations

from irsim_gym.arraytypes import CellMap, Flags, Floats, Ints
from irsim_gym.geometry.cells import capsule_meets_cells
from irsim_gym.geometry.polygons import contains_point
from irsim_gym.geometry.segments import gap2, point_segment_distance2, segment_segment_distance2
from irsim_gym.jit import kernel

Outlines = tuple[Floats, Ints, Ints, Floats, Ints, Ints, Flags, Flags, CellMap | None]
"""The nine tables of one world: see the package's description."""


@kernel
def way_is_free(
    segments: Floats,
    segment_start: Ints,
    segment_count: Ints,
    discs: Floats,
    disc_start: Ints,
    disc_count: Ints,
    solid: Flags,
    blocks: Flags,
    cells: CellMap | None,
    radius: float,
    ax: float,
    ay: float,
    bx: float,
    by: float,
) -> bool:
    """Return whether a body can go straight from a to b without touching a body or cell that blocks; a may equal b.

    Args:
        segments: As all tables up to ``cells``: see the package's description.
        segment_start: See there.
        segment_count: See there.
        discs: See there.
        disc_start: See there.
        disc_count: See there.
        solid: See there.
        blocks: See there.
        cells: See there.
        radius: Radius of the moving body [m].
        ax: Start [m].
        ay: Start [m].
        bx: End [m].
        by: End [m].
    """
    radius2 = radius * radius
    for b in range(blocks.shape[0]):
        if not blocks[b]:
            continue
        for d in range(disc_start[b], disc_start[b] + disc_count[b]):
            reach = radius + discs[d, 2]
            if point_segment_distance2(discs[d, 0], discs[d, 1], ax, ay, bx, by) <= reach * reach:
                return False
        start, count = segment_start[b], segment_count[b]
        for s in range(start, start + count):
            cx, cy, dx, dy = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
            if gap2(ax, ay, bx, by, cx, cy, dx, dy) > radius2:
                continue
            if segment_segment_distance2(ax, ay, bx, by, cx, cy, dx, dy) <= radius2:
                return False
        if solid[b] and contains_point(segments, start, count, ax, ay):
            return False
    return not capsule_meets_cells(cells, ax, ay, bx, by, radius)
