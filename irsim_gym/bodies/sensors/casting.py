"""Casts beams against the outlines of bodies, with inverse depths."""

import numpy as np

from irsim_gym.bodies.sensors.scan_tables import ScanTables, beam_row, mount
from irsim_gym.simulator.geometry import ray_chunks
from irsim_gym.simulator.geometry.polygons import contains_point
from irsim_gym.simulator.geometry.ray_chunks import AWAY, BLOCK, CHUNK, Eye, Fan
from irsim_gym.simulator.geometry.rays import inverse_depth_disc, inverse_depth_segment
from irsim_gym.simulator.world.names import Floats, Ints, Model, Rays, State, kernel, row_of


@kernel
def cast_segments(segments: Floats, eye: Eye, beams_x: Rays, beams_y: Rays, inverse: Rays) -> None:
    """Cast beams against segments, from both sides. Coordinates are rotated in float64, then rounded to float32."""
    x, y, cosine, sine = eye
    for s in range(segments.shape[0]):
        ax, ay, bx, by = segments[s, 0] - x, segments[s, 1] - y, segments[s, 2] - x, segments[s, 3] - y
        px, py = np.float32(cosine * ax + sine * ay), np.float32(cosine * ay - sine * ax)
        qx, qy = np.float32(cosine * bx + sine * by), np.float32(cosine * by - sine * bx)
        inverse_depth_segment(px, py, qx, qy, beams_x, beams_y, inverse)


@kernel
def cast_discs(discs: Floats, eye: Eye, beams_x: Rays, beams_y: Rays, inverse: Rays) -> None:
    """Cast beams against discs, from both sides. Coordinates are rotated in float64, then rounded to float32."""
    x, y, cosine, sine = eye
    for d in range(discs.shape[0]):
        cx, cy, radius = discs[d, 0] - x, discs[d, 1] - y, np.float32(discs[d, 2])
        ahead, aside = np.float32(cosine * cx + sine * cy), np.float32(cosine * cy - sine * cx)
        inverse_depth_disc(ahead, aside, radius, beams_x, beams_y, inverse)


@kernel
def cast_bodies(worlds: Ints, slot: int, tables: ScanTables, model: Model, state: State) -> None:
    """Write the ranges of all members in all given worlds.

    Reads: tables (beams_x, beams_y, cast_min, density, discs, ends, first, inverse, limits, members, offset, range_max,
        rays, rounds, sides), model (disc_count, disc_start, present, reach, segment_count, segment_start, solid,
        unobstructed), state (direction, discs, pose, segments).
    Writes: tables (discs, ends, inverse, limits, ranges, rays, rounds, sides).
    """
    ends, limits, discs, rays = tables.ends[slot], tables.limits[slot], tables.discs[slot], tables.rays[slot]
    # The row of directions that is in ``rays``: it is laid out again only where another sensor has another row.
    laid = -1
    for w in worlds:
        reaches, rows, rings = model.reach[row_of(model.reach, w)], state.segments[w], state.discs[w]
        poses, there = state.pose[w], model.present[w]
        n_segments = model.segment_count[row_of(model.segment_count, w)]
        n_discs = model.disc_count[row_of(model.disc_count, w)]
        for k in range(tables.members.shape[0]):
            body, far, row = tables.members[k], tables.range_max[k], beam_row(w, k, tables)
            eye = mount(poses[body], state.direction[w, body], tables.offset[w, k])
            if row != laid:
                ray_chunks.lay_beams(tables.beams_x[row], tables.beams_y[row], rays)
                laid = row
            ray_chunks.clear_depths(rays)
            n_sides, n_rounds = 0, 0
            for b in range(there.shape[0]):
                dx, dy, within = poses[b, 0] - eye.x, poses[b, 1] - eye.y, far + reaches[b]
                distance2 = dx * dx + dy * dy
                if distance2 > within * within or b == body or model.unobstructed[b] or not there[b]:
                    continue
                for d in range(model.disc_start[b], model.disc_start[b] + n_discs[b]):
                    if n_rounds == CHUNK:
                        n_sides = n_rounds = cast_chunk(n_sides, n_rounds, ends, eye, far, row, slot, tables)
                    discs.x[n_rounds], discs.y[n_rounds] = rings[d, 0] - eye.x, rings[d, 1] - eye.y
                    discs.radius[n_rounds] = rings[d, 2]
                    n_rounds += 1
                start, end, limit = model.segment_start[b], model.segment_start[b] + n_segments[b], 0.0
                # From outside, only an area's front sides can be hit. A curve, or an area around the sensor, shows
                # both.
                if not model.solid[b] or (
                    distance2 <= reaches[b] * reaches[b] and contains_point(rows, start, end - start, (eye.x, eye.y))
                ):
                    limit = np.inf
                for s in range(start, end):
                    if n_sides == CHUNK:
                        n_sides = n_rounds = cast_chunk(n_sides, n_rounds, ends, eye, far, row, slot, tables)
                    for c in range(4):
                        ends[4 * n_sides + c] = rows[s, c]
                    limits[n_sides] = limit
                    n_sides += 1
            cast_chunk(n_sides, n_rounds, ends, eye, far, row, slot, tables)
            write_ranges(rays, tables.cast_min[k], far, tables.ranges[w, k])


@kernel(inlined=True)
def cast_chunk(
    n_sides: int, n_rounds: int, ends: Floats, eye: Eye, far: float, row: int, slot: int, tables: ScanTables
) -> int:
    """Cast against a chunk of segments, which may be seen edge-on, and discs, which may contain the sensor.

    All are prepared before the first is cast, because the processor waits for the number of beams that each may meet.
    Return 0, the number of primitives left in the chunk.

    Reads: tables (beams_x, beams_y, density, discs, first, inverse, limits, rays, rounds, sides).
    Writes: tables (discs, inverse, rays, rounds, sides).

    Args:
        n_sides: Number of segments.
        n_rounds: Number of discs, which are ``tables.discs``.
        ends: Ends of the segments, as ``tables.ends``.
        eye: The sensor.
        far: Its range [m].
        row: Its beams.
        slot: Whose scratch memory.
    """
    discs, sides, rounds = tables.discs[slot], tables.sides[slot], tables.rounds[slot]
    rays, inverse = tables.rays[slot], tables.inverse[slot]
    # Discs are prepared in whole vectors: the places behind the last are filled with points that are 1 m ahead.
    whole_lanes = (n_rounds + 7) // 8 * 8
    fan = Fan(inverse.shape[0], np.float32(tables.first), np.float32(tables.density))
    for j in range(n_rounds, whole_lanes):
        discs.x[j], discs.radius[j] = 1.0, 0.0
    n_edges = ray_chunks.prepare_segments(n_sides, eye, far, ends, tables.limits[slot], sides)
    n_around = ray_chunks.prepare_discs(whole_lanes, eye, discs, rounds)
    ray_chunks.span_segments(n_sides, fan, sides)
    ray_chunks.span_discs(n_rounds, fan, rounds)
    ray_chunks.raise_by_segments(ray_chunks.list_kept(n_sides, sides), sides, rays)
    ray_chunks.raise_by_discs(ray_chunks.list_kept(n_rounds, rounds), rounds, rays)
    # The rare cases in which the fast formulas fail: segments seen edge-on, and discs around the sensor.
    if n_edges + n_around > 0:
        beams_x, beams_y = tables.beams_x[row], tables.beams_y[row]
        for i in range(inverse.shape[0]):
            inverse[i] = np.float32(0.0)
        for j in range(n_sides):
            if sides.mark[j] < 0:
                inverse_depth_segment(sides.ax[j], sides.ay[j], sides.bx[j], sides.by[j], beams_x, beams_y, inverse)
        for j in range(n_rounds):
            if rounds.mark[j] < 0:
                inverse_depth_disc(rounds.x[j], rounds.y[j], np.float32(discs.radius[j]), beams_x, beams_y, inverse)
        for i in range(inverse.shape[0]):
            # Place of beam i's depth in ``rays``, see ``lay_beams``.
            at = i // BLOCK * AWAY + i % BLOCK
            rays[at] = max(rays[at], inverse[i])
    return 0


@kernel(inlined=True)
def write_ranges(rays: Rays, range_min: float, range_max: float, ranges: Rays) -> None:
    """Turn inverse depths into ranges; a beam that meets nothing in range reports range_max."""
    shortest, farthest = np.float32(range_min), np.float32(range_max)
    # A smaller inverse depth is a larger range; up to ``least``, the range is exactly range_max.
    least = np.float32(1.0) / farthest
    for b in range(rays.shape[0] // AWAY):
        depths, row = rays[AWAY * b : AWAY * b + BLOCK], ranges[BLOCK * b : BLOCK * b + BLOCK]
        for i in range(row.shape[0]):
            depth = np.float32(1.0) / max(depths[i], least)
            depth = farthest if depths[i] <= least else depth
            row[i] = shortest if depth < shortest else depth
