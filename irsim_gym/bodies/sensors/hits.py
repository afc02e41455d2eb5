"""Finds the bodies that beams hit, and their velocities, for scans that report velocities."""

import numpy as np

from irsim_gym.bodies.sensors.casting import cast_discs, cast_segments
from irsim_gym.bodies.sensors.scan_tables import ScanTables, beam_row, mount_pose
from irsim_gym.simulator.geometry.ray_chunks import Eye
from irsim_gym.simulator.world.names import Floats, Ints, Model, Rays, Records, State, kernel, normal, row_of

SAME = 1e-4
"""Tolerance [m, and as a share] by which a range must be shorter than that to the nearest body to end at the map."""


@kernel
def raise_ranges(worlds: Ints, tables: ScanTables) -> None:
    """Raise ranges below range_min to range_min.

    Reads: tables (range_min, ranges).
    Writes: tables (ranges).
    """
    for w in worlds:
        for k in range(tables.members.shape[0]):
            shortest, ranges = np.float32(tables.range_min[k]), tables.ranges[w, k]
            for j in range(ranges.shape[0]):
                ranges[j] = max(ranges[j], shortest)


@kernel
def find_hits(worlds: Ints, slot: int, tables: ScanTables, model: Model, state: State) -> None:
    """Cast against one body after another, and note for each beam which one is nearest.

    Call this before noise is added and before ranges are raised to range_min.

    Reads: tables (beams_x, beams_y, inverse, members, nearest, offset, range_max, ranges), model (disc_count,
        disc_start, map_frame, present, reach, segment_count, segment_start, unobstructed), state (discs, pose,
        segments).
    Writes: tables (hit, inverse, nearest).
    """
    inverse, nearest = tables.inverse[slot], tables.nearest[slot]
    for w in worlds:
        reaches = model.reach[row_of(model.reach, w)]
        n_segments = model.segment_count[row_of(model.segment_count, w)]
        n_discs = model.disc_count[row_of(model.disc_count, w)]
        for k in range(tables.members.shape[0]):
            body, far, row, hit = tables.members[k], tables.range_max[k], beam_row(w, k, tables), tables.hit[w, k]
            beams_x, beams_y = tables.beams_x[row], tables.beams_y[row]
            x, y, heading = mount_pose(state.pose[w, body], tables.offset[w, k])
            eye = Eye(x, y, np.cos(heading), np.sin(heading))
            nearest[:] = np.float32(0.0)
            hit[:] = -1
            for b in range(model.present.shape[1]):
                dx, dy, near = state.pose[w, b, 0] - x, state.pose[w, b, 1] - y, far + reaches[b]
                if b == body or model.unobstructed[b] or not model.present[w, b] or dx * dx + dy * dy > near * near:
                    continue
                inverse[:] = np.float32(0.0)
                disc, segment = model.disc_start[b], model.segment_start[b]
                cast_discs(state.discs[w, disc : disc + n_discs[b]], eye, beams_x, beams_y, inverse)
                cast_segments(state.segments[w, segment : segment + n_segments[b]], eye, beams_x, beams_y, inverse)
                note_nearer(b, inverse, nearest, hit)
            name_hits(np.float32(far), model.map_frame[0].body, tables.ranges[w, k], nearest, hit)


@kernel
def note_nearer(b: int, inverse: Rays, nearest: Rays, hit: Ints) -> None:
    """Note body b for the beams that it stops before all other bodies."""
    for j in range(hit.shape[0]):
        if inverse[j] > nearest[j]:
            nearest[j], hit[j] = inverse[j], b


@kernel
def name_hits(far: np.float32, map_body: int, ranges: Rays, nearest: Rays, hit: Ints) -> None:
    """Remove the bodies of free beams, and note the map where it ends a beam before any body does."""
    for j in range(hit.shape[0]):
        if ranges[j] >= far:
            hit[j] = -1
        # 1 / ``nearest`` is the distance of the nearest body. A range clearly shorter than that ends at the map.
        elif map_body >= 0 and nearest[j] * (ranges[j] * (1.0 + SAME) + SAME) < 1.0:
            hit[j] = map_body


@kernel
def write_velocity(worlds: Ints, tables: ScanTables, state: State, velocity: Floats) -> None:
    """Write the world-frame velocity [m/s] of what each beam hits, 0 for free beams.

    Reads: tables (hit), state (twist).
    Writes: velocity.

    Args:
        worlds: The worlds to treat.
        velocity: Written, shape ``(n_worlds, n_members, 2, n_beams)``.
    """
    for w in worlds:
        for k in range(tables.hit.shape[1]):
            for j in range(tables.hit.shape[2]):
                b = tables.hit[w, k, j]
                for axis in range(2):
                    velocity[w, k, axis, j] = state.twist[w, b, axis] if b >= 0 else 0.0


@kernel
def write_radial_velocity(
    worlds: Ints, params: Records, tables: ScanTables, state: State, radial_velocity: Floats
) -> None:
    """Write the rate of change of the range of each valid beam [m/s], 0 for the others.

    The velocity of the sensor is that of the origin of its body. The part due to rotation at an offset is ignored, as
    in IR-SIM. With ``motion_compensate``, the sensor counts as standing still.

    Reads: tables (cast_angles, hit, members, offset, range_max, range_min, ranges), state (pose, random, twist).
    Writes: state (random), radial_velocity.
    """
    for w in worlds:
        for k in range(tables.members.shape[0]):
            body, row, error = tables.members[k], beam_row(w, k, tables), 0.0
            shortest, farthest = np.float32(tables.range_min[k]), np.float32(tables.range_max[k])
            # How much of the sensor's own velocity is subtracted.
            share = 0.0 if params[k].motion_compensate else 1.0
            heading = state.pose[w, body, 2] + tables.offset[w, k, 2]
            for j in range(tables.hit.shape[2]):
                # Drawn for every beam, so that the stream does not depend on what the beams hit.
                if params[k].velocity_noise_std > 0.0:
                    error = normal(state.random, w, 0.0, params[k].velocity_noise_std)
                radial_velocity[w, k, j] = 0.0
                b = tables.hit[w, k, j]
                if b >= 0 and shortest < tables.ranges[w, k, j] < farthest:
                    vx = state.twist[w, b, 0] - share * state.twist[w, body, 0]
                    vy = state.twist[w, b, 1] - share * state.twist[w, body, 1]
                    angle = heading + tables.cast_angles[row, j]
                    radial_velocity[w, k, j] = vx * np.cos(angle) + vy * np.sin(angle) + error
