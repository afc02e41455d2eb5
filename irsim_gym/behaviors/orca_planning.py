"""How the members of an ORCA group choose their velocities."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.behaviors.orca_lines import away, disc_plane
from irsim_gym.behaviors.orca_map import SIGHT, add_map
from irsim_gym.behaviors.orca_neighbors import find_nearest, find_walls
from irsim_gym.behaviors.orca_walls import is_covered, see_edge, wall_plane
from irsim_gym.behaviors.steering import to_command
from irsim_gym.behaviors.surroundings import Scene, row_of
from irsim_gym.geometry.linear_program import choose
from irsim_gym.jit import kernel
from irsim_gym.world.model import DIFFERENTIAL

AT_GOAL = 0.1
"""An omnidirectional body this near to its goal wants to stand still [m]."""

TOLERANCE = 0.1
"""A differential body does not turn for a smaller angle [rad]."""

SLOW = 0.02
"""A differential body does not move for a lower speed [m/s]."""

HALF, WHOLE = 0.5, 1.0

HELD = 0.1
"""Whose plan is slower than this part of its greatest speed is held up by others."""


@kernel
def speed_cap(drive: int, fastest: Floats, most: float) -> float:
    """Return the speed [m/s] that a drive can hold in every direction, no more than ``most`` (NaN: no bound)."""
    speed = fastest[0] if drive == DIFFERENTIAL else min(fastest[0], fastest[1])
    return float(max(min(speed, most) if most == most else speed, 0.0))


@kernel
def preferred_velocity(drive: int, fastest: Floats, speed: float, dx: float, dy: float) -> tuple[float, float]:
    """Return the velocity [m/s] towards a goal at (dx, dy) [m].

    As in IR-SIM, an omnidirectional body stops near its goal and leans to the axis on which it is faster; a
    differential one always drives at full speed.
    """
    if drive == DIFFERENTIAL:
        angle = np.arctan2(dy, dx)
        return speed * np.cos(angle), speed * np.sin(angle)
    distance = np.sqrt(dx * dx + dy * dy)
    if distance <= AT_GOAL:
        return 0.0, 0.0
    vx, vy = fastest[0] * dx / distance, fastest[1] * dy / distance
    length = np.sqrt(vx * vx + vy * vy)
    if length < 1e-9:
        return 0.0, 0.0
    return speed * vx / length, speed * vy / length


@kernel
def is_held(plan: Floats, speed: float) -> bool:
    """Return whether a body is on its way, but hardly moves."""
    planned2 = plan[0] * plan[0] + plan[1] * plan[1]
    return bool(0.0 < planned2 < HELD * HELD * speed * speed)


class Scratch(NamedTuple):
    """Memory of one shard: for a search of bodies, the sides and discs in reach, those of a map, and half-planes."""

    found: Ints
    nearest_gap: Floats
    nearest: Ints
    parts_gap: Floats
    parts: Ints
    owners: Ints
    sides: Floats
    sides_gap: Floats
    sides_order: Ints
    edge: Floats
    planes: Floats
    spare: Floats


@kernel
def plan_velocities(
    worlds: Ints,
    deciding: Ints,
    params: Any,
    step_time: Floats,
    drive: Ints,
    velocity_max: Floats,
    has_goal: Flags,
    seen: Flags,
    plans: Flags,
    walls: Ints,
    is_wall: Flags,
    goal: Floats,
    plan: Floats,
    scene: Scene,
    scratch: Scratch,
    command: Floats,
) -> None:
    """Write the velocities that the members choose, in the world frame, to the first two components of ``command``."""
    options, planes = params[0], scratch.planes
    for i in range(worlds.shape[0]):
        w = worlds[i]
        radii, pose = scene.radius[row_of(scene.radius, w)], scene.pose[w]
        for k in range(deciding.shape[0]):
            b = deciding[k]
            if not scene.present[w, b]:
                continue
            fastest = velocity_max[row_of(velocity_max, w), b]
            speed, own = speed_cap(drive[b], fastest, options.maxSpeed), radii[b] + options.safe_radius
            within, n_hard = options.timeHorizonObst * speed + own, 0
            if walls.shape[0] > 0:
                n_hard = add_walls(
                    w, walls, is_wall, within, own, options.timeHorizonObst, pose[b], plan[w, b], scene, scratch
                )
            if scene.map_frame[4] >= 0.0:
                n_hard = add_map(
                    own, options.timeHorizonObst, min(within, SIGHT), pose[b], plan[w, b],
                    scene.map_frame, scene.map_squares,
                    scratch.sides, scratch.sides_gap, scratch.sides_order, scratch.edge, planes, n_hard,
                )  # fmt: skip
            n_near = add_members(
                b, own, options, step_time[0], scene.bucket_frame, scene.bucket_first[w], scene.bucket_next[w],
                seen, plans, scene.present[w], radii, pose, plan[w], scene.twist[w],
                scratch.found, scratch.nearest_gap, scratch.nearest, planes[n_hard:],
            )  # fmt: skip
            wanted_x, wanted_y = 0.0, 0.0
            if has_goal[b]:
                wanted_x, wanted_y = preferred_velocity(
                    drive[b], fastest, speed, goal[w, b, 0] - pose[b, 0], goal[w, b, 1] - pose[b, 1]
                )
            if options.sidestep and is_held(plan[w, b], speed):
                wanted_x, wanted_y = wanted_y, -wanted_x
            command[w, b, 0], command[w, b, 1] = choose(
                planes, n_hard, n_hard + n_near, speed, wanted_x, wanted_y, scratch.spare
            )


@kernel
def add_members(
    b: int,
    own: float,
    options: Any,
    step_time: float,
    frame: Floats,
    bucket_first: Ints,
    bucket_next: Ints,
    seen: Flags,
    plans: Flags,
    present: Flags,
    radii: Floats,
    pose: Floats,
    plan: Floats,
    twist: Floats,
    found: Ints,
    gap2: Floats,
    nearest: Ints,
    planes: Floats,
) -> int:
    """Write the half-planes of the nearest members of the group; return their number.

    Members that plan do as they planned, the others as they move. Who overlaps has one step to part.
    """
    count = find_nearest(
        b, options.neighborDist, frame, bucket_first, bucket_next, seen, present, pose, found, gap2, nearest
    )
    for j in range(count):
        q = nearest[j]
        both = own + radii[q] + options.safe_radius
        overlap = gap2[j] <= both * both
        other_vx, other_vy = (plan[q, 0], plan[q, 1]) if plans[q] else (twist[q, 0], twist[q, 1])
        disc_plane(
            pose[q, 0] - pose[b, 0],
            pose[q, 1] - pose[b, 1],
            plan[b, 0],
            plan[b, 1],
            other_vx,
            other_vy,
            both,
            step_time if overlap else options.timeHorizon,
            HALF,
            1.0 if b < q else -1.0,
            planes[j],
        )
    return count


@kernel
def add_walls(
    w: int,
    walls: Ints,
    is_wall: Flags,
    within: float,
    radius: float,
    horizon: float,
    pose: Floats,
    velocity: Floats,
    scene: Scene,
    scratch: Scratch,
) -> int:
    """Write the half-planes of what never moves and is nearer than ``within`` [m]; return their number.

    A disc that is touched already need not be left at once, as a wall need not; only going nearer is forbidden.
    """
    x, y, planes, edge, segments = pose[0], pose[1], scratch.planes, scratch.edge, scene.segments[w]
    n_segments = scene.segment_count[row_of(scene.segment_count, w)]
    n_parts = find_walls(
        x, y, within, walls, is_wall, scene.bucket_frame, scene.bucket_first[w], scene.bucket_next[w],
        scene.present[w], scene.pose[w], scene.reach[row_of(scene.reach, w)],
        scene.segment_start, n_segments, segments,
        scene.disc_start, scene.disc_count[row_of(scene.disc_count, w)], scene.discs[w],
        scratch.found, scratch.parts_gap, scratch.parts, scratch.owners,
    )  # fmt: skip
    count = 0
    for i in range(n_parts):
        s = scratch.parts[i]
        q = scratch.owners[s]
        if s >= segments.shape[0]:
            disc = scene.discs[w, s - segments.shape[0]]
            dx, dy, both = disc[0] - x, disc[1] - y, disc[2] + radius
            gap2 = dx * dx + dy * dy
            if gap2 <= both * both:
                planes[count, 0], planes[count, 1] = away(-dx, -dy, np.sqrt(gap2), dx, dy)
                planes[count, 2] = 0.0
            else:
                disc_plane(dx, dy, velocity[0], velocity[1], 0.0, 0.0, both, horizon, WHOLE, 1.0, planes[count])
            count += 1
        elif see_edge(segments, scene.segment_start[q], n_segments[q], s, scene.solid[q], x, y, edge):
            covered = is_covered(planes, count, edge[0], edge[1], edge[2], edge[3], radius, horizon)
            if not covered and wall_plane(edge, velocity[0], velocity[1], radius, horizon, planes[count]):
                count += 1
    return count


@kernel
def command_plans(
    worlds: Ints,
    deciding: Ints,
    step_time: Floats,
    drive: Ints,
    velocity_max: Floats,
    present: Flags,
    pose: Floats,
    plan: Floats,
    command: Floats,
) -> None:
    """Keep the chosen velocities as plans, and turn them into commands of the drives."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for k in range(deciding.shape[0]):
            b = deciding[k]
            if not present[w, b]:
                continue
            plan[w, b, 0], plan[w, b, 1] = command[w, b, 0], command[w, b, 1]
            to_command(
                drive[b],
                pose[w, b, 2],
                plan[w, b, 0],
                plan[w, b, 1],
                step_time[0],
                TOLERANCE,
                SLOW,
                velocity_max[w % velocity_max.shape[0], b, 1],
                command[w, b],
            )
