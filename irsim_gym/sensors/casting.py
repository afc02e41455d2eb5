"""Casting beams against the outlines of bodies, in inverse-depth form."""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Rays
from irsim_gym.geometry.polygons import contains_point
from irsim_gym.geometry.rays import inverse_depth_disc, inverse_depth_segment
from irsim_gym.geometry.segments import point_segment_distance2
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
    beams_x: Rays,
    beams_y: Rays,
    pose: Floats,
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
    seen: Rays,
    inverse: Rays,
    ranges: Rays,
) -> None:
    """Write the ranges of all members in all given worlds.

    The beams of member k in world w are row ``w * n_members + k`` of ``beams_x`` and ``beams_y``, or their only row.
    """
    for i in range(worlds.shape[0]):
        w = worlds[i]
        reaches = reach[w % reach.shape[0]]
        n_segments, n_discs = segment_count[w % segment_count.shape[0]], disc_count[w % disc_count.shape[0]]
        rows, rounds = segments[w], discs[w]
        for k in range(members.shape[0]):
            own, far = members[k], params[k].range_max
            row = w * members.shape[0] + k if beams_x.shape[0] > 1 else 0
            along_x, along_y = beams_x[row], beams_y[row]
            x, y, heading = mount_pose(pose[w, own], params[k].offset)
            cosine, sine = np.cos(heading), np.sin(heading)
            inverse[:] = np.float32(0.0)
            n_seen = 0
            for b in range(present.shape[1]):
                if b == own or unobstructed[b] or not present[w, b]:
                    continue
                near = far + reaches[b]
                dx, dy = pose[w, b, 0] - x, pose[w, b, 1] - y
                distance2 = dx * dx + dy * dy
                if distance2 > near * near:
                    continue
                for d in range(disc_start[b], disc_start[b] + n_discs[b]):
                    cast_disc(rounds[d, 0] - x, rounds[d, 1] - y, rounds[d, 2], cosine, sine, along_x, along_y, inverse)
                start, end = segment_start[b], segment_start[b] + n_segments[b]
                two_sided = not solid[b] or (
                    distance2 <= reaches[b] * reaches[b] and contains_point(rows, start, end - start, x, y)
                )
                sure = far - reaches[b]
                in_range = sure > 0.0 and distance2 <= sure * sure
                for s in range(start, end):
                    ax, ay, bx, by = rows[s, 0] - x, rows[s, 1] - y, rows[s, 2] - x, rows[s, 3] - y
                    if (two_sided or faces(ax, ay, bx, by)) and (in_range or is_near(ax, ay, bx, by, far)):
                        seen[n_seen, 0] = np.float32(cosine * ax + sine * ay)
                        seen[n_seen, 1] = np.float32(cosine * ay - sine * ax)
                        seen[n_seen, 2] = np.float32(cosine * bx + sine * by)
                        seen[n_seen, 3] = np.float32(cosine * by - sine * bx)
                        n_seen += 1
            cast_seen(n_seen, seen, along_x, along_y, inverse)
            write_ranges(inverse, params[k].range_min, far, ranges[w, k])


@kernel
def cast_seen(count: int, seen: Rays, beams_x: Rays, beams_y: Rays, inverse: Rays) -> None:
    """Cast against the first rows of ``seen``, segments in the sensor frame [m].

    A loop of its own keeps the ray kernel's vector code whole: among the tests of ``cast_bodies`` it takes twice the
    time.
    """
    for s in range(count):
        inverse_depth_segment(seen[s, 0], seen[s, 1], seen[s, 2], seen[s, 3], beams_x, beams_y, inverse)


@kernel
def mount_pose(pose: Floats, offset: Floats) -> tuple[float, float, float]:
    """Return the sensor's pose in the world frame."""
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    x = pose[0] + cosine * offset[0] - sine * offset[1]
    y = pose[1] + sine * offset[0] + cosine * offset[1]
    return x, y, pose[2] + offset[2]


@kernel
def faces(ax: float, ay: float, bx: float, by: float) -> bool:
    """Return whether a segment of a solid body shows its front to the origin.

    Boundaries of solid bodies run counter-clockwise, so their front lies to the right of the segment.
    """
    return (by - ay) * ax - (bx - ax) * ay <= 0.0


@kernel
def is_near(ax: float, ay: float, bx: float, by: float, far: float) -> bool:
    """Return whether a segment comes within ``far`` [m] of the origin."""
    return bool(point_segment_distance2(0.0, 0.0, ax, ay, bx, by) <= far * far)


@kernel
def write_ranges(inverse: Rays, range_min: float, range_max: float, ranges: Rays) -> None:
    """Turn inverse depths into ranges; a beam that meets nothing in range reports range_max."""
    shortest, farthest = np.float32(range_min), np.float32(range_max)
    least = np.float32(1.0) / farthest
    for i in range(ranges.shape[0]):
        depth = np.float32(1.0) / max(inverse[i], least)
        depth = farthest if inverse[i] <= least else depth
        ranges[i] = shortest if depth < shortest else depth
