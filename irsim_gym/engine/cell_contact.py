"""Contact with the cells of the obstacle map, in kernels of their own: a world without a map never needs them."""

from __future__ import annotations

from irsim_gym.arraytypes import CellMap, Flags, Floats, Ints
from irsim_gym.geometry.cell_room import room_about
from irsim_gym.geometry.cells import outline_cells_distance, outline_meets_cells
from irsim_gym.jit import kernel


@kernel
def find_cell_contacts(
    worlds: Ints,
    bodies: Ints,
    cells: CellMap,
    present: Flags,
    unobstructed: Flags,
    solid: Flags,
    reach: Floats,
    pose: Floats,
    segment_start: Ints,
    segment_count: Ints,
    segments: Floats,
    disc_start: Ints,
    disc_count: Ints,
    discs: Floats,
    collided: Flags,
    hit: Ints,
) -> None:
    """Note which bodies touch an occupied cell, for them and for the map's own body."""
    own = int(cells[0][4])
    for i in range(worlds.shape[0]):
        w = worlds[i]
        n_segments, n_discs = segment_count[w % segment_count.shape[0]], disc_count[w % disc_count.shape[0]]
        for k in range(bodies.shape[0]):
            b = bodies[k]
            if b == own or unobstructed[b] or not present[w, b] or not present[w, own]:
                continue
            if room_about(cells, pose[w, b, 0], pose[w, b, 1])[0] > reach[w % reach.shape[0], b]:
                continue
            if outline_meets_cells(
                cells, segments[w], segment_start[b], n_segments[b], discs[w], disc_start[b], n_discs[b], solid[b]
            ):
                collided[w, b], collided[w, own] = True, True
                hit[w, b] = own if hit[w, b] < 0 else min(hit[w, b], own)
                hit[w, own] = b if hit[w, own] < 0 else min(hit[w, own], b)


@kernel
def measure_cell_clearance(
    worlds: Ints,
    bodies: Ints,
    cells: CellMap,
    present: Flags,
    solid: Flags,
    reach: Floats,
    pose: Floats,
    segment_start: Ints,
    segment_count: Ints,
    segments: Floats,
    disc_start: Ints,
    disc_count: Ints,
    discs: Floats,
    distance: Floats,
) -> None:
    """Lower the surface distances of bodies [m], shape ``(n_worlds, n_bodies)``, to that of the nearest cell."""
    own = int(cells[0][4])
    for i in range(worlds.shape[0]):
        w = worlds[i]
        n_segments, n_discs = segment_count[w % segment_count.shape[0]], disc_count[w % disc_count.shape[0]]
        for k in range(bodies.shape[0]):
            b = bodies[k]
            if b == own or not present[w, own]:
                continue
            least = room_about(cells, pose[w, b, 0], pose[w, b, 1])[0]
            if least - reach[w % reach.shape[0], b] < distance[w, k]:
                distance[w, k] = outline_cells_distance(
                    cells,
                    segments[w],
                    segment_start[b],
                    n_segments[b],
                    discs[w],
                    disc_start[b],
                    n_discs[b],
                    solid[b],
                    distance[w, k],
                )
