"""Casting beams against the outlines of bodies, in inverse-depth form."""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Rays, Spans
from irsim_gym.geometry.angles import turned
from irsim_gym.geometry.polygons import contains_point
from irsim_gym.geometry.ray_chunks import (
    CHUNK,
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


@kernel
def cast_outline(
    x: float,
    y: float,
    cosine: float,
    sine: float,
    segments: Floats,
    discs: Floats,
    beams_x: Rays,
    beams_y: Rays,
    inverse: Rays,
) -> None:
    """Cast the beams of a sensor at (x, y) against all rows of an outline, from both sides."""
    for s in range(segments.shape[0]):
        ax, ay, bx, by = segments[s, 0] - x, segments[s, 1] - y, segments[s, 2] - x, segments[s, 3] - y
        cast_segment(ax, ay, bx, by, cosine, sine, beams_x, beams_y, inverse)
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
    pose: Floats,
    direction: Floats,
    present: Flags,
    unobstructed: Flags,
    solid: Flags,
    reach: Floats,
    segment_start: Ints,
    segment_count: Ints,
    segments: Floats,
    disc_start: Ints,
    disc_count: Ints,
    discs: Floats,
    near: Floats,
    slopes: Rays,
    spans: Spans,
    inverse: Rays,
    ranges: Rays,
) -> None:
    """Write the ranges of all members in all given worlds.

    The beams of member k in world w are row ``w * n_members + k`` of ``beams_x`` and ``beams_y``, or their only row;
    ``fan`` holds the direction of the first one [rad] and their number per rad, 0 where they are not evenly spread.
    ``near``, ``slopes`` and ``spans`` are scratch, see ``geometry/ray_chunks.py``.
    """
    sides, limits, rounds = near[: 4 * CHUNK], near[4 * CHUNK : 5 * CHUNK], near[5 * CHUNK :]
    first, density = np.float32(fan[0]), np.float32(fan[1])
    for i in range(worlds.shape[0]):
        w = worlds[i]
        reaches, rows, rings = reach[min(w, reach.shape[0] - 1)], segments[w], discs[w]
        here, there = pose[w], present[w]
        n_segments, n_discs = (
            segment_count[min(w, segment_count.shape[0] - 1)],
            disc_count[min(w, disc_count.shape[0] - 1)],
        )
        for k in range(members.shape[0]):
            own, far, row = members[k], params[k].range_max, w * members.shape[0] + k if beams_x.shape[0] > 1 else 0
            x, y, cosine, sine = mount(here[own], direction[w, own], params[k].offset)
            beams = first, density, slopes, spans, beams_x[row], beams_y[row], inverse
            for j in range(inverse.shape[0]):
                inverse[j] = np.float32(0.0)
            n_sides, n_rounds = 0, 0
            for b in range(there.shape[0]):
                dx, dy, within = here[b, 0] - x, here[b, 1] - y, far + reaches[b]
                distance2 = dx * dx + dy * dy
                if distance2 > within * within or b == own or unobstructed[b] or not there[b]:
                    continue
                for d in range(disc_start[b], disc_start[b] + n_discs[b]):
                    if n_rounds == CHUNK:
                        n_rounds = cast_rounds(n_rounds, cosine, sine, rounds, *beams)
                    rounds[n_rounds], rounds[n_rounds + CHUNK] = rings[d, 0] - x, rings[d, 1] - y
                    rounds[n_rounds + 2 * CHUNK] = rings[d, 2]
                    n_rounds += 1
                start, end, limit = segment_start[b], segment_start[b] + n_segments[b], 0.0
                if not solid[b] or (
                    distance2 <= reaches[b] * reaches[b] and contains_point(rows, start, end - start, x, y)
                ):
                    limit = np.inf
                for s in range(start, end):
                    if n_sides == CHUNK:
                        n_sides = cast_sides(n_sides, x, y, cosine, sine, far, sides, limits, *beams)
                    for c in range(4):
                        sides[4 * n_sides + c] = rows[s, c]
                    limits[n_sides] = limit
                    n_sides += 1
            if n_rounds > 0:
                cast_rounds(n_rounds, cosine, sine, rounds, *beams)
            if n_sides > 0:
                cast_sides(n_sides, x, y, cosine, sine, far, sides, limits, *beams)
            write_ranges(inverse, params[k].range_min, far, ranges[w, k])


@kernel(inlined=True)
def cast_sides(
    count: int,
    x: float,
    y: float,
    cosine: float,
    sine: float,
    far: float,
    rows: Floats,
    limits: Floats,
    first: np.float32,
    density: np.float32,
    slopes: Rays,
    spans: Spans,
    beams_x: Rays,
    beams_y: Rays,
    inverse: Rays,
) -> int:
    """Cast against a chunk of segments, which may be seen edge-on; return 0, the number that is left."""
    n_edges = prepare_segments(count, x, y, cosine, sine, far, rows, limits, slopes, spans)
    span_segments(count, inverse.shape[0], first, density, slopes, spans)
    raise_by_segments(list_kept(count, spans), slopes, spans, beams_x, beams_y, inverse)
    if n_edges > 0:
        for j in range(count):
            if spans[j] < 0:
                ax, ay = slopes[j + 5 * CHUNK], slopes[j + 6 * CHUNK]
                bx, by = slopes[j + 7 * CHUNK], slopes[j + 8 * CHUNK]
                inverse_depth_segment(ax, ay, bx, by, beams_x, beams_y, inverse)
    return 0


@kernel(inlined=True)
def cast_rounds(
    count: int,
    cosine: float,
    sine: float,
    near: Floats,
    first: np.float32,
    density: np.float32,
    slopes: Rays,
    spans: Spans,
    beams_x: Rays,
    beams_y: Rays,
    inverse: Rays,
) -> int:
    """Cast against a chunk of discs, which may hold the sensor; return 0, the number that is left."""
    whole_lanes = (count + 7) // 8 * 8
    for j in range(count, whole_lanes):
        near[j], near[j + 2 * CHUNK] = 1.0, 0.0
    n_around = prepare_discs(whole_lanes, cosine, sine, near, slopes, spans)
    span_discs(count, inverse.shape[0], first, density, slopes, spans)
    raise_by_discs(list_kept(count, spans), slopes, spans, beams_x, beams_y, inverse)
    if n_around > 0:
        for j in range(count):
            if spans[j] < 0:
                radius = np.float32(near[j + 2 * CHUNK])
                inverse_depth_disc(slopes[j], slopes[j + CHUNK], radius, beams_x, beams_y, inverse)
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
def write_ranges(inverse: Rays, range_min: float, range_max: float, ranges: Rays) -> None:
    """Turn inverse depths into ranges; a beam that meets nothing in range reports range_max."""
    shortest, farthest = np.float32(range_min), np.float32(range_max)
    least = np.float32(1.0) / farthest
    for i in range(ranges.shape[0]):
        depth = np.float32(1.0) / max(inverse[i], least)
        depth = farthest if inverse[i] <= least else depth
        ranges[i] = shortest if depth < shortest else depth
