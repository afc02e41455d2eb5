"""What the beams hit, and how fast that moves. Only scans that report velocities ask for it."""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import Floats, Ints, Rays
from irsim_gym.jit import kernel
from irsim_gym.rng import normal
from irsim_gym.sensors.casting import cast_disc, cast_segment, mount_pose
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

SAME = 1e-4
"""A range this much shorter [m, and as a share of it] than the way to the nearest body ends at the map."""


def prepare(group: Group, n_slots: int) -> None:
    """Allocate ``hit``: the body that each beam hits, -1 for none, shape ``(n_worlds, n_members, n_beams)``.

    Beams are cast down to distance 0 then: who comes first below range_min is not told from ranges that end there.
    """
    table = group.arrays
    table["cast_params"] = table["cast_params"].copy()
    table["cast_params"]["range_min"] = 0.0
    table["hit"] = np.full(table["ranges"].shape, -1, np.int64)
    table["nearest"] = np.zeros((n_slots, table["beams_x"].shape[1]), np.float32)


def find(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Write which body each beam hits, from ranges without noise and below range_min too."""
    table = group.arrays
    find_hits(
        shard.worlds,
        group.members,
        table["cast_params"],
        table["beams_x"],
        table["beams_y"],
        model,
        state,
        table["ranges"],
        table["inverse"][shard.slot],
        table["nearest"][shard.slot],
        table["hit"],
    )


def clip(group: Group, shard: Shard) -> None:
    """Bring the ranges that ``find`` needed as they are into the sensor's band."""
    raise_ranges(shard.worlds, group.params, group.arrays["ranges"])


@kernel
def raise_ranges(worlds: Ints, params: Any, ranges: Rays) -> None:
    """Report range_min for what is nearer."""
    for w in worlds:
        for k in range(params.shape[0]):
            shortest = np.float32(params[k].range_min)
            for j in range(ranges.shape[2]):
                ranges[w, k, j] = max(ranges[w, k, j], shortest)


@kernel
def find_hits(
    worlds: Ints,
    members: Ints,
    params: Any,
    beams_x: Rays,
    beams_y: Rays,
    model: WorldModel,
    state: WorldState,
    ranges: Rays,
    inverse: Rays,
    nearest: Rays,
    hit: Ints,
) -> None:
    """Cast against one body after the other and note for each beam which came nearest."""
    for w in worlds:
        reaches = model.reach[row_of(model.reach, w)]
        n_segments, n_discs = (
            model.segment_count[row_of(model.segment_count, w)],
            model.disc_count[row_of(model.disc_count, w)],
        )
        for k in range(members.shape[0]):
            own, far = members[k], params[k].range_max
            row = w * members.shape[0] + k if beams_x.shape[0] > 1 else 0
            along_x, along_y = beams_x[row], beams_y[row]
            x, y, heading = mount_pose(state.pose[w, own], params[k].offset)
            cosine, sine = np.cos(heading), np.sin(heading)
            nearest[:] = np.float32(0.0)
            hit[w, k, :] = -1
            for b in range(model.present.shape[1]):
                dx, dy, near = state.pose[w, b, 0] - x, state.pose[w, b, 1] - y, far + reaches[b]
                if b == own or model.unobstructed[b] or not model.present[w, b] or dx * dx + dy * dy > near * near:
                    continue
                inverse[:] = np.float32(0.0)
                for d in range(model.disc_start[b], model.disc_start[b] + n_discs[b]):
                    cx, cy, radius = state.discs[w, d, 0] - x, state.discs[w, d, 1] - y, state.discs[w, d, 2]
                    cast_disc(cx, cy, radius, cosine, sine, along_x, along_y, inverse)
                for s in range(model.segment_start[b], model.segment_start[b] + n_segments[b]):
                    ax, ay = state.segments[w, s, 0] - x, state.segments[w, s, 1] - y
                    bx, by = state.segments[w, s, 2] - x, state.segments[w, s, 3] - y
                    cast_segment(ax, ay, bx, by, cosine, sine, along_x, along_y, inverse)
                note_nearer(b, inverse, nearest, hit[w, k])
            settle(np.float32(far), model.map_frame[0].body, ranges[w, k], nearest, hit[w, k])


@kernel
def note_nearer(b: int, inverse: Rays, nearest: Rays, hit: Ints) -> None:
    """Note body b for the beams that it stops before all others."""
    for j in range(hit.shape[0]):
        if inverse[j] > nearest[j]:
            nearest[j], hit[j] = inverse[j], b


@kernel
def settle(far: np.float32, map_body: int, ranges: Rays, nearest: Rays, hit: Ints) -> None:
    """Take back what was noted for free beams, and name the map where it ends a beam before any body does."""
    for j in range(hit.shape[0]):
        if ranges[j] >= far:
            hit[j] = -1
        elif map_body >= 0 and nearest[j] * (ranges[j] * (1.0 + SAME) + SAME) < 1.0:
            hit[j] = map_body


@kernel
def write_velocity(worlds: Ints, twist: Floats, hit: Ints, velocity: Floats) -> None:
    """Write the world-frame velocity [m/s] of what each beam hits, 0 for free beams.

    Args:
        worlds: The worlds to treat.
        twist: Velocities of the bodies [m/s, m/s, rad/s], shape ``(n_worlds, n_bodies, 3)``.
        hit: Body that each beam hits, shape ``(n_worlds, n_members, n_beams)``.
        velocity: Written, shape ``(n_worlds, n_members, 2, n_beams)``.
    """
    for w in worlds:
        for k in range(hit.shape[1]):
            for j in range(hit.shape[2]):
                b = hit[w, k, j]
                for axis in range(2):
                    velocity[w, k, axis, j] = twist[w, b, axis] if b >= 0 else 0.0


@kernel
def write_radial_velocity(
    worlds: Ints,
    members: Ints,
    params: Any,
    cast_angles: Floats,
    state: WorldState,
    ranges: Rays,
    hit: Ints,
    radial_velocity: Floats,
) -> None:
    """Write how fast the range of each valid beam grows [m/s], 0 for the others.

    The sensor's own velocity is that of its body's origin; what its turning adds at an offset is left out, as in
    IR-SIM. With ``motion_compensate`` the sensor counts as standing still.
    """
    for w in worlds:
        for k in range(members.shape[0]):
            own, row = members[k], w * members.shape[0] + k if cast_angles.shape[0] > 1 else 0
            shortest, farthest = np.float32(params[k].range_min), np.float32(params[k].range_max)
            share = 0.0 if params[k].motion_compensate else 1.0
            heading = state.pose[w, own, 2] + params[k].offset[2]
            for j in range(hit.shape[2]):
                error = 0.0
                if params[k].velocity_noise_std > 0.0:
                    error = normal(state.random, w, 0.0, params[k].velocity_noise_std)
                radial_velocity[w, k, j] = 0.0
                b = hit[w, k, j]
                if b >= 0 and shortest < ranges[w, k, j] < farthest:
                    vx, vy = (
                        state.twist[w, b, 0] - share * state.twist[w, own, 0],
                        state.twist[w, b, 1] - share * state.twist[w, own, 1],
                    )
                    angle = heading + cast_angles[row, j]
                    radial_velocity[w, k, j] = vx * np.cos(angle) + vy * np.sin(angle) + error
