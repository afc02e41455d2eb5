"""How the members of an ORCA group choose their velocities."""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.behaviors.orca_lines import away, disc_plane
from irsim_gym.behaviors.orca_neighbors import find_nearest, find_walls
from irsim_gym.behaviors.orca_walls import is_covered, see_edge, wall_plane
from irsim_gym.behaviors.steering import to_command
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


@kernel
def plan_velocities(
    worlds: Ints,
    deciding: Ints,
    params: Any,
    step_time: Floats,
    drive: Ints,
    velocity_max: Floats,
    radius: Floats,
    has_goal: Flags,
    present: Flags,
    seen: Flags,
    plans: Flags,
    frame: Floats,
    bucket_first: Ints,
    bucket_next: Ints,
    pose: Floats,
    twist: Floats,
    goal: Floats,
    plan: Floats,
    walls: Ints,
    is_wall: Flags,
    reach: Floats,
    solid: Flags,
    segment_start: Ints,
    segment_count: Ints,
    segments: Floats,
    disc_start: Ints,
    disc_count: Ints,
    discs: Floats,
    found: Ints,
    nearest_gap: Floats,
    nearest: Ints,
    parts_gap: Floats,
    parts: Ints,
    owners: Ints,
    edge: Floats,
    planes: Floats,
    spare: Floats,
    command: Floats,
) -> None:
    """Write the velocities that the members choose, in the world frame, to the first two components of ``command``."""
    options = params[0]
    for i in range(worlds.shape[0]):
        w = worlds[i]
        radii = radius[w % radius.shape[0]]
        for k in range(deciding.shape[0]):
            b = deciding[k]
            if not present[w, b]:
                continue
            fastest = velocity_max[w % velocity_max.shape[0], b]
            speed, own = speed_cap(drive[b], fastest, options.maxSpeed), radii[b] + options.safe_radius
            n_parts, n_hard = 0, 0
            if walls.shape[0] > 0:
                n_parts = find_walls(
                    pose[w, b, 0], pose[w, b, 1], options.timeHorizonObst * speed + own, walls, is_wall, frame,
                    bucket_first[w], bucket_next[w], present[w], pose[w], reach[w % reach.shape[0]],
                    segment_start, segment_count[w % segment_count.shape[0]], segments[w],
                    disc_start, disc_count[w % disc_count.shape[0]], discs[w],
                    found, parts_gap, parts, owners,
                )  # fmt: skip
                n_hard = add_walls(
                    parts[:n_parts], owners, own, options.timeHorizonObst, pose[w, b], plan[w, b], solid,
                    segment_start, segment_count[w % segment_count.shape[0]], segments[w], discs[w], edge, planes,
                )  # fmt: skip
            n_near = add_members(
                b, own, options, step_time[0], frame, bucket_first[w], bucket_next[w], seen, plans, present[w],
                radii, pose[w], plan[w], twist[w], found, nearest_gap, nearest, planes[n_hard:],
            )  # fmt: skip
            wanted_x, wanted_y = 0.0, 0.0
            if has_goal[b]:
                wanted_x, wanted_y = preferred_velocity(
                    drive[b], fastest, speed, goal[w, b, 0] - pose[w, b, 0], goal[w, b, 1] - pose[w, b, 1]
                )
            if options.sidestep and is_held(plan[w, b], speed):
                wanted_x, wanted_y = wanted_y, -wanted_x
            command[w, b, 0], command[w, b, 1] = choose(
                planes, n_hard, n_hard + n_near, speed, wanted_x, wanted_y, spare
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
            planes[j],
        )
    return count


@kernel
def add_walls(
    parts: Ints,
    owners: Ints,
    radius: float,
    horizon: float,
    pose: Floats,
    velocity: Floats,
    solid: Flags,
    segment_start: Ints,
    segment_count: Ints,
    segments: Floats,
    discs: Floats,
    edge: Floats,
    planes: Floats,
) -> int:
    """Write the half-planes of what never moves, as ``find_walls`` found it; return their number.

    A disc that is touched already need not be left at once, as a wall need not; only going nearer is forbidden.
    """
    count = 0
    for i in range(parts.shape[0]):
        s, q = parts[i], owners[parts[i]]
        if s >= segments.shape[0]:
            d = s - segments.shape[0]
            x, y, both = discs[d, 0] - pose[0], discs[d, 1] - pose[1], discs[d, 2] + radius
            gap2 = x * x + y * y
            if gap2 <= both * both:
                planes[count, 0], planes[count, 1] = away(-x, -y, np.sqrt(gap2), x, y)
                planes[count, 2] = 0.0
            else:
                disc_plane(x, y, velocity[0], velocity[1], 0.0, 0.0, both, horizon, WHOLE, planes[count])
            count += 1
        elif see_edge(segments, segment_start[q], segment_count[q], s, solid[q], pose[0], pose[1], edge):
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
