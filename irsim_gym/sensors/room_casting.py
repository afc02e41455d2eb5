"""Casting in rooms where all outlines together fit into one chunk: they are looked at where they lie.

Which rows can be seen at all depends on the sensor's body and on who is present, which is mostly everybody, so that it
is noted once for many worlds. Looking for bodies in reach first takes longer than preparing all rows in lanes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Rays, Spans
from irsim_gym.geometry.polygons import contains_point
from irsim_gym.geometry.ray_chunks import CHUNK, clear_depths, lay_beams
from irsim_gym.jit import kernel
from irsim_gym.sensors.casting import cast_chunk, mount, write_ranges
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

DISCS, OWNERS, AREAS = 0, CHUNK, 2 * CHUNK
"""What the three parts of ``listed`` hold: discs that can be seen, whose they are, and bodies with an inside."""


def is_small(model: WorldModel) -> bool:
    """Return whether all outlines of a world fit into a chunk, and so do its bodies."""
    sizes = model.local_segments.shape[1], model.local_discs.shape[1], len(model.role)
    return bool(max(sizes) <= CHUNK)


@kernel
def cast_room(
    worlds: Ints,
    members: Ints,
    params: Any,
    fan: Floats,
    beams_x: Rays,
    beams_y: Rays,
    model: WorldModel,
    state: WorldState,
    near: Floats,
    slopes: Rays,
    spans: Spans,
    rays: Rays,
    inverse: Rays,
    listed: Ints,
    ranges: Rays,
) -> None:
    """Write the ranges of all members in all given worlds, as ``cast_bodies`` does for any world."""
    limits, rounds = near[4 * CHUNK : 5 * CHUNK], near[5 * CHUNK :]
    first, density, laid = np.float32(fan[0]), np.float32(fan[1]), -1
    is_noted, is_shared = False, model.segment_count.shape[0] == 1 and model.disc_count.shape[0] == 1
    n_rings, n_areas = 0, 0
    for w in worlds:
        rows, rings, here, there = state.segments[w], state.discs[w], state.pose[w], model.present[w]
        reaches = model.reach[row_of(model.reach, w)]
        n_segments, n_discs = (
            model.segment_count[row_of(model.segment_count, w)],
            model.disc_count[row_of(model.disc_count, w)],
        )
        is_complete = is_shared and count_present(there) == there.shape[0]
        is_noted = is_noted and is_complete
        for k in range(members.shape[0]):
            own, far, row = members[k], params[k].range_max, w * members.shape[0] + k if beams_x.shape[0] > 1 else 0
            x, y, cosine, sine = mount(here[own], state.direction[w, own], params[k].offset)
            scratch = slopes, spans, rays, inverse
            beams = x, y, cosine, sine, far, first, density, beams_x[row], beams_y[row], *scratch
            if not is_noted:
                n_rings, n_areas = note_rows(there, model, n_segments, n_discs, limits, listed)
                is_noted = is_complete
            for s in range(model.segment_start[own], model.segment_start[own] + n_segments[own]):
                limits[s], is_noted = -np.inf, False
            for m in range(n_areas):
                b = listed[AREAS + m]
                dx, dy, start, count = here[b, 0] - x, here[b, 1] - y, model.segment_start[b], n_segments[b]
                is_near = dx * dx + dy * dy <= reaches[b] * reaches[b] and b != own
                if is_near and contains_point(rows, start, count, x, y):
                    limits[start : start + count], is_noted = np.inf, False
            n_rounds = 0
            for m in range(n_rings):
                d = listed[DISCS + m]
                dx, dy, within = rings[d, 0] - x, rings[d, 1] - y, far + rings[d, 2]
                rounds[n_rounds], rounds[n_rounds + CHUNK], rounds[n_rounds + 2 * CHUNK] = dx, dy, rings[d, 2]
                n_rounds += (listed[OWNERS + m] != own) & (dx * dx + dy * dy <= within * within)
            if row != laid:
                lay_beams(beams_x[row], beams_y[row], rays)
                laid = row
            clear_depths(rays)
            cast_chunk(rows.shape[0], n_rounds, rows.reshape(-1), limits, rounds, *beams)
            write_ranges(rays, params[k].range_min, far, ranges[w, k])


@kernel
def count_present(present: Flags) -> int:
    """Return how many bodies there are."""
    n = 0
    for b in range(present.shape[0]):
        n += present[b]
    return n


@kernel
def note_rows(
    present: Flags, model: WorldModel, n_segments: Ints, n_discs: Ints, limits: Floats, listed: Ints
) -> tuple[int, int]:
    """Write from which sides segments are seen, and list discs and areas; return the numbers of both."""
    n_rings, n_areas = 0, 0
    for s in range(CHUNK):
        limits[s] = -np.inf
    for b in range(present.shape[0]):
        if model.unobstructed[b] or not present[b]:
            continue
        for d in range(model.disc_start[b], model.disc_start[b] + n_discs[b]):
            listed[DISCS + n_rings], listed[OWNERS + n_rings] = d, b
            n_rings += 1
        for s in range(model.segment_start[b], model.segment_start[b] + n_segments[b]):
            limits[s] = 0.0 if model.solid[b] else np.inf
        if model.solid[b] and n_segments[b] > 0:
            listed[AREAS + n_areas] = b
            n_areas += 1
    return n_rings, n_areas
