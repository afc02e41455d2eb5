"""Casting beams against the outlines of bodies, in inverse-depth form."""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import Floats, Ints, Rays, Spans
from irsim_gym.geometry.angles import turned
from irsim_gym.geometry.polygons import contains_point
from irsim_gym.geometry.ray_chunks import (
    AWAY,
    BLOCK,
    CHUNK,
    clear_depths,
    lay_beams,
    list_kept,
    prepare_discs,
    prepare_segments,
    raise_by_discs,
    raise_by_segments,
    span_discs,
    span_segments,
)
from irsim_gym.geometry.rays import inverse_depth_disc, inverse_depth_segment
from irsim_gym.jit import kernel
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

BOWS, ARCS = 9 * CHUNK, 4 * CHUNK
"""Where the discs of a chunk begin in ``slopes`` and ``spans``, after the segments."""


@kernel
def cast_segments(
    x: float, y: float, cosine: float, sine: float, segments: Floats, beams_x: Rays, beams_y: Rays, inverse: Rays
) -> None:
    """Cast the beams of a sensor at (x, y) against the segments of an outline, from both sides."""
    for s in range(segments.shape[0]):
        ax, ay, bx, by = segments[s, 0] - x, segments[s, 1] - y, segments[s, 2] - x, segments[s, 3] - y
        cast_segment(ax, ay, bx, by, cosine, sine, beams_x, beams_y, inverse)


@kernel
def cast_discs(
    x: float, y: float, cosine: float, sine: float, discs: Floats, beams_x: Rays, beams_y: Rays, inverse: Rays
) -> None:
    """Cast the beams of a sensor at (x, y) against the discs of an outline, from both sides."""
    for d in range(discs.shape[0]):
        cast_disc(discs[d, 0] - x, discs[d, 1] - y, discs[d, 2], cosine, sine, beams_x, beams_y, inverse)


@kernel
def cast_segment(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    cosine: float,
    sine: float,
    beams_x: Rays,
    beams_y: Rays,
    inverse: Rays,
) -> None:
    """Cast against a segment given relative to the sensor: turned in float64, then float32."""
    inverse_depth_segment(
        np.float32(cosine * ax + sine * ay),
        np.float32(cosine * ay - sine * ax),
        np.float32(cosine * bx + sine * by),
        np.float32(cosine * by - sine * bx),
        beams_x,
        beams_y,
        inverse,
    )


@kernel
def cast_disc(
    cx: float, cy: float, radius: float, cosine: float, sine: float, beams_x: Rays, beams_y: Rays, inverse: Rays
) -> None:
    """Cast against a disc given relative to the sensor: turned in float64, then float32."""
    inverse_depth_disc(
        np.float32(cosine * cx + sine * cy),
        np.float32(cosine * cy - sine * cx),
        np.float32(radius),
        beams_x,
        beams_y,
        inverse,
    )


@kernel
def cast_bodies(
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
    ranges: Rays,
) -> None:
    """Write the ranges of all members in all given worlds.

    The beams of member k in world w are row ``w * n_members + k`` of ``beams_x`` and ``beams_y``, or their only row;
    ``fan`` holds the direction of the first one [rad] and their number per rad, 0 where they are not evenly spread.
    ``near``, ``slopes``, ``spans``, ``rays`` and ``inverse`` are scratch, see ``geometry/ray_chunks.py``.
    """
    sides, limits, rounds = near[: 4 * CHUNK], near[4 * CHUNK : 5 * CHUNK], near[5 * CHUNK :]
    first, density, laid = np.float32(fan[0]), np.float32(fan[1]), -1
    for w in worlds:
        reaches, rows, rings = model.reach[row_of(model.reach, w)], state.segments[w], state.discs[w]
        here, there = state.pose[w], model.present[w]
        n_segments, n_discs = (
            model.segment_count[row_of(model.segment_count, w)],
            model.disc_count[row_of(model.disc_count, w)],
        )
        for k in range(members.shape[0]):
            own, far, row = members[k], params[k].range_max, w * members.shape[0] + k if beams_x.shape[0] > 1 else 0
            x, y, cosine, sine = mount(here[own], state.direction[w, own], params[k].offset)
            scratch = slopes, spans, rays, inverse
            beams = x, y, cosine, sine, far, first, density, beams_x[row], beams_y[row], *scratch
            if row != laid:
                lay_beams(beams_x[row], beams_y[row], rays)
                laid = row
            clear_depths(rays)
            n_sides, n_rounds = 0, 0
            for b in range(there.shape[0]):
                dx, dy, within = here[b, 0] - x, here[b, 1] - y, far + reaches[b]
                distance2 = dx * dx + dy * dy
                if distance2 > within * within or b == own or model.unobstructed[b] or not there[b]:
                    continue
                for d in range(model.disc_start[b], model.disc_start[b] + n_discs[b]):
                    if n_rounds == CHUNK:
                        n_sides = n_rounds = cast_chunk(n_sides, n_rounds, sides, limits, rounds, *beams)
                    rounds[n_rounds], rounds[n_rounds + CHUNK] = rings[d, 0] - x, rings[d, 1] - y
                    rounds[n_rounds + 2 * CHUNK] = rings[d, 2]
                    n_rounds += 1
                start, end, limit = model.segment_start[b], model.segment_start[b] + n_segments[b], 0.0
                if not model.solid[b] or (
                    distance2 <= reaches[b] * reaches[b] and contains_point(rows, start, end - start, x, y)
                ):
                    limit = np.inf
                for s in range(start, end):
                    if n_sides == CHUNK:
                        n_sides = n_rounds = cast_chunk(n_sides, n_rounds, sides, limits, rounds, *beams)
                    for c in range(4):
                        sides[4 * n_sides + c] = rows[s, c]
                    limits[n_sides] = limit
                    n_sides += 1
            cast_chunk(n_sides, n_rounds, sides, limits, rounds, *beams)
            write_ranges(rays, params[k].range_min, far, ranges[w, k])


@kernel(inlined=True)
def cast_chunk(
    n_sides: int,
    n_rounds: int,
    sides: Floats,
    limits: Floats,
    rounds: Floats,
    x: float,
    y: float,
    cosine: float,
    sine: float,
    far: float,
    first: np.float32,
    density: np.float32,
    beams_x: Rays,
    beams_y: Rays,
    slopes: Rays,
    spans: Spans,
    rays: Rays,
    inverse: Rays,
) -> int:
    """Cast against segments, which may be seen edge-on, and discs, which may hold the sensor; return 0, what is left.

    All are made ready before the first is cast: how many beams may meet it is what the processor has to wait for.
    """
    bows, arcs, n_beams = slopes[BOWS:], spans[ARCS:], inverse.shape[0]
    whole_lanes = (n_rounds + 7) // 8 * 8
    for j in range(n_rounds, whole_lanes):
        rounds[j], rounds[j + 2 * CHUNK] = 1.0, 0.0
    n_edges = prepare_segments(n_sides, (x, y, cosine, sine), far, sides, limits, slopes, spans)
    n_around = prepare_discs(whole_lanes, cosine, sine, rounds, bows, arcs)
    span_segments(n_sides, n_beams, first, density, slopes, spans)
    span_discs(n_rounds, n_beams, first, density, bows, arcs)
    raise_by_segments(list_kept(n_sides, spans), slopes, spans, rays)
    raise_by_discs(list_kept(n_rounds, arcs), bows, arcs, rays)
    if n_edges + n_around > 0:
        for i in range(inverse.shape[0]):
            inverse[i] = np.float32(0.0)
        for j in range(n_sides):
            if spans[j] < 0:
                ax, ay = slopes[j + 5 * CHUNK], slopes[j + 6 * CHUNK]
                bx, by = slopes[j + 7 * CHUNK], slopes[j + 8 * CHUNK]
                inverse_depth_segment(ax, ay, bx, by, beams_x, beams_y, inverse)
        for j in range(n_rounds):
            if arcs[j] < 0:
                radius = np.float32(rounds[j + 2 * CHUNK])
                inverse_depth_disc(bows[j], bows[j + CHUNK], radius, beams_x, beams_y, inverse)
        for i in range(inverse.shape[0]):
            at = i // BLOCK * AWAY + i % BLOCK
            rays[at] = max(rays[at], inverse[i])
    return 0


@kernel(inlined=True)
def mount(pose: Floats, direction: Floats, offset: Floats) -> tuple[float, float, float, float]:
    """Return the sensor's place in the world frame [m], and cosine and sine of its heading."""
    cosine, sine = turned(pose[2], direction)
    x = pose[0] + cosine * offset[0] - sine * offset[1]
    y = pose[1] + sine * offset[0] + cosine * offset[1]
    if offset[2] != 0.0:
        cosine, sine = np.cos(pose[2] + offset[2]), np.sin(pose[2] + offset[2])
    return x, y, cosine, sine


@kernel
def mount_pose(pose: Floats, offset: Floats) -> tuple[float, float, float]:
    """Return the sensor's pose in the world frame."""
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    x = pose[0] + cosine * offset[0] - sine * offset[1]
    y = pose[1] + sine * offset[0] + cosine * offset[1]
    return x, y, pose[2] + offset[2]


@kernel(inlined=True)
def write_ranges(rays: Rays, range_min: float, range_max: float, ranges: Rays) -> None:
    """Turn inverse depths into ranges; a beam that meets nothing in range reports range_max."""
    shortest, farthest = np.float32(range_min), np.float32(range_max)
    least = np.float32(1.0) / farthest
    for b in range(rays.shape[0] // AWAY):
        depths, row = rays[AWAY * b : AWAY * b + BLOCK], ranges[BLOCK * b : BLOCK * b + BLOCK]
        for i in range(row.shape[0]):
            depth = np.float32(1.0) / max(depths[i], least)
            depth = farthest if depths[i] <= least else depth
            row[i] = shortest if depth < shortest else depth
