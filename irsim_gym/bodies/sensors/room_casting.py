"""Casts beams in small worlds, in which all outlines together fit into one chunk, without copying them.

Which rows are visible depends only on the body of the sensor and on the present bodies, usually all, so it is computed
once for many worlds. Preparing all rows with vector instructions is faster than searching for bodies in range first.
"""

from typing import Any

import numpy as np

from irsim_gym.bodies.sensors.casting import cast_chunk, write_ranges
from irsim_gym.bodies.sensors.scan_tables import ScanTables, beam_row, mount
from irsim_gym.simulator.geometry.polygons import contains_point
from irsim_gym.simulator.geometry.ray_chunks import CHUNK, clear_depths, lay_beams
from irsim_gym.simulator.world.names import Flags, Ints, Model, State, kernel, row_of


def is_small(model: Model) -> bool:
    """Return whether all outlines and all bodies of a world fit into a chunk."""
    sizes = model.local_segments.shape[1], model.local_discs.shape[1], len(model.role)
    return bool(max(sizes) <= CHUNK)


@kernel
def cast_room(worlds: Ints, slot: int, tables: ScanTables, model: Model, state: State) -> None:
    """Write the ranges of all members in all given worlds, as ``cast_bodies`` does for any world.

    Reads: tables (areas, beams_x, beams_y, cast_min, density, discs, first, inverse, limits, members, offset, owners,
        range_max, rays, rounds, seen, sides), model (disc_count, disc_start, present, reach, segment_count,
        segment_start, solid, unobstructed), state (direction, discs, pose, segments).
    Writes: tables (areas, discs, inverse, limits, owners, ranges, rays, rounds, seen, sides).
    """
    limits, discs, rays = tables.limits[slot], tables.discs[slot], tables.rays[slot]
    seen, owners, areas = tables.seen[slot], tables.owners[slot], tables.areas[slot]
    laid, n_rings, n_areas = -1, 0, 0
    # ``note_rows`` holds for the next world, too, if worlds share their outlines' rows and every body is present.
    is_noted, is_shared = False, model.segment_count.shape[0] == 1 and model.disc_count.shape[0] == 1
    for w in worlds:
        rows, rings, here, there = state.segments[w], state.discs[w], state.pose[w], model.present[w]
        reaches = model.reach[row_of(model.reach, w)]
        n_segments = model.segment_count[row_of(model.segment_count, w)]
        is_complete = is_shared and count_present(there) == there.shape[0]
        is_noted = is_noted and is_complete
        for k in range(tables.members.shape[0]):
            own, far, row = tables.members[k], tables.range_max[k], beam_row(w, k, tables)
            eye = mount(here[own], state.direction[w, own], tables.offset[w, k])
            if not is_noted:
                n_rings, n_areas = note_rows(w, slot, tables, model)
                is_noted = is_complete
            for s in range(model.segment_start[own], model.segment_start[own] + n_segments[own]):
                # The body of the sensor is not seen. The limits written here are no longer those of ``note_rows``.
                limits[s], is_noted = -np.inf, False
            for m in range(n_areas):
                b = areas[m]
                dx, dy, start, count = here[b, 0] - eye.x, here[b, 1] - eye.y, model.segment_start[b], n_segments[b]
                is_near = dx * dx + dy * dy <= reaches[b] * reaches[b] and b != own
                if is_near and contains_point(rows, start, count, (eye.x, eye.y)):
                    # From within an area, its sides are seen from behind.
                    limits[start : start + count], is_noted = np.inf, False
            # A literal has a type of its own, for which cast_chunk would be compiled a second time.
            n_rounds: Any = np.int64(0)
            for m in range(n_rings):
                d = seen[m]
                dx, dy, within = rings[d, 0] - eye.x, rings[d, 1] - eye.y, far + rings[d, 2]
                discs.x[n_rounds], discs.y[n_rounds], discs.radius[n_rounds] = dx, dy, rings[d, 2]
                # A disc out of range, or of the body itself, is overwritten by the next one.
                n_rounds += (owners[m] != own) & (dx * dx + dy * dy <= within * within)
            if row != laid:
                lay_beams(tables.beams_x[row], tables.beams_y[row], rays)
                laid = row
            clear_depths(rays)
            cast_chunk(rows.shape[0], n_rounds, rows.reshape(-1), eye, far, row, slot, tables)
            write_ranges(rays, tables.cast_min[k], far, tables.ranges[w, k])


@kernel
def count_present(present: Flags) -> int:
    """Return the number of present bodies."""
    n = 0
    for b in range(present.shape[0]):
        n += present[b]
    return n


@kernel
def note_rows(w: int, slot: int, tables: ScanTables, model: Model) -> tuple[int, int]:
    """Write from which sides segments are seen, and list discs and areas; return the numbers of both.

    Reads: model (disc_count, disc_start, present, segment_count, segment_start, solid, unobstructed).
    Writes: tables (areas, limits, owners, seen).
    """
    limits, seen, owners, areas = tables.limits[slot], tables.seen[slot], tables.owners[slot], tables.areas[slot]
    n_segments = model.segment_count[row_of(model.segment_count, w)]
    n_discs = model.disc_count[row_of(model.disc_count, w)]
    n_rings, n_areas = 0, 0
    for s in range(CHUNK):
        limits[s] = -np.inf
    for b in range(model.present.shape[1]):
        if model.unobstructed[b] or not model.present[w, b]:
            continue
        for d in range(model.disc_start[b], model.disc_start[b] + n_discs[b]):
            seen[n_rings], owners[n_rings] = d, b
            n_rings += 1
        for s in range(model.segment_start[b], model.segment_start[b] + n_segments[b]):
            limits[s] = 0.0 if model.solid[b] else np.inf
        if model.solid[b] and n_segments[b] > 0:
            areas[n_areas] = b
            n_areas += 1
    return n_rings, n_areas
