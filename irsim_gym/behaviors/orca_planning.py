"""How the members of an ORCA group choose their velocities."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.behaviors.orca_crowd import Crowd, gather, keep_nearest, sort_members
from irsim_gym.behaviors.orca_lines import LANES, away, disc_plane, disc_planes
from irsim_gym.behaviors.orca_map import SIGHT, add_map
from irsim_gym.behaviors.orca_neighbors import find_walls
from irsim_gym.behaviors.orca_walls import is_covered, see_edge, wall_plane
from irsim_gym.behaviors.steering import to_command
from irsim_gym.behaviors.surroundings import Scene
from irsim_gym.geometry.linear_program import choose
from irsim_gym.jit import kernel
from irsim_gym.world.model import DIFFERENTIAL, WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

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
def speed_cap(drive: int, fastest_x: float, fastest_y: float, most: float) -> float:
    """Return the speed [m/s] that a drive can hold in every direction, no more than ``most`` (NaN: no bound)."""
    speed = fastest_x if drive == DIFFERENTIAL else min(fastest_x, fastest_y)
    return float(max(min(speed, most) if most == most else speed, 0.0))


@kernel
def preferred_velocity(
    drive: int, fastest_x: float, fastest_y: float, speed: float, dx: float, dy: float
) -> tuple[float, float]:
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
    vx, vy = fastest_x * dx / distance, fastest_y * dy / distance
    length = np.sqrt(vx * vx + vy * vy)
    if length < 1e-9:
        return 0.0, 0.0
    return speed * vx / length, speed * vy / length


@kernel
def is_held(vx: float, vy: float, speed: float) -> bool:
    """Return whether a body with this plan [m/s] is on its way, but hardly moves."""
    planned2 = vx * vx + vy * vy
    return bool(0.0 < planned2 < HELD * HELD * speed * speed)


class Scratch(NamedTuple):
    """Memory of one shard: for a search of bodies, the sides and discs in reach, those of a map, and half-planes."""

    nearby: Ints
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
    members: Ints,
    squares: Floats,
    params: Any,
    model: WorldModel,
    state: WorldState,
    seen: Flags,
    plans: Flags,
    walls: Ints,
    is_wall: Flags,
    scene: Scene,
    crowd: Crowd,
    scratch: Scratch,
) -> None:
    """Write the velocities that the members choose, in the world frame, to the first two components of ``command``.

    The circle in which a member looks for others grows until it holds enough of them.
    """
    options, dt, most = params[0], model.step_time[0], crowd.nearest.shape[0]
    columns, rows, first_ring, reach = int(squares[3]), int(squares[4]), squares[5], options.neighborDist
    places, moves, body, _, starts, found, gap2, nearest, nearest_gap, lanes = crowd
    planes, spare, has_obstacles = scratch.planes, scratch.spare, walls.shape[0] > 0 or scene.map_frame[0].body >= 0
    for w in worlds:
        radii, pose, planned = scene.radius[row_of(scene.radius, w)], scene.pose[w], state.plan[w]
        limits = model.velocity_max[row_of(model.velocity_max, w)]
        sort_members(members, squares, seen, plans, scene.present[w], radii, pose, planned, scene.twist[w], crowd)
        for place in range(columns * rows):
            row = place // columns
            for m in range(starts[place], starts[place + 1]):
                b = body[m]
                if not plans[b]:
                    continue
                x, y, ring = pose[b, 0], pose[b, 1], 1
                while True:
                    within = reach if ring >= max(columns, rows) else min(reach, ring * first_ring)
                    n_found = gather(
                        m, x, y, within, ring, place - row * columns, row, columns, rows, starts, places, gap2, found
                    )
                    if n_found >= most or within >= reach:
                        break
                    ring *= 2
                n_near = keep_nearest(n_found, gap2, found, body, nearest_gap, nearest)
                own = radii[b] + options.safe_radius
                speed, n_hard = speed_cap(model.drive[b], limits[b, 0], limits[b, 1], options.maxSpeed), 0
                if has_obstacles:
                    n_hard = add_obstacles(w, walls, is_wall, own, speed, options, pose[b], planned[b], scene, scratch)
                add_members(
                    m, n_near, n_hard, own, options.safe_radius, x, y, planned[b, 0], planned[b, 1], dt,
                    options.timeHorizon, body, places, moves, nearest, lanes, planes,
                )  # fmt: skip
                wanted_x, wanted_y = 0.0, 0.0
                if model.has_goal[b]:
                    wanted_x, wanted_y = preferred_velocity(
                        model.drive[b],
                        limits[b, 0],
                        limits[b, 1],
                        speed,
                        state.goal[w, b, 0] - x,
                        state.goal[w, b, 1] - y,
                    )
                if options.sidestep and is_held(planned[b, 0], planned[b, 1], speed):
                    wanted_x, wanted_y = wanted_y, -wanted_x
                state.command[w, b, 0], state.command[w, b, 1] = choose(
                    planes, n_hard, n_hard + n_near, speed, wanted_x, wanted_y, spare
                )


@kernel
def add_members(
    m: int,
    n_near: int,
    n_hard: int,
    own: float,
    safe: float,
    x: float,
    y: float,
    vx: float,
    vy: float,
    step_time: float,
    horizon: float,
    body: Ints,
    places: Floats,
    moves: Floats,
    nearest: Ints,
    lanes: Floats,
    planes: Floats,
) -> None:
    """Write the half-planes of the nearest members behind the hard ones. Who overlaps has one step to part."""
    for first in range(0, n_near, LANES):
        n_lanes = min(n_near - first, LANES)
        for j in range(n_lanes):
            q = nearest[first + j]
            lanes[j], lanes[LANES + j] = places[0, q] - x, places[1, q] - y
            lanes[2 * LANES + j], lanes[3 * LANES + j] = moves[q, 0], moves[q, 1]
            lanes[4 * LANES + j] = own + moves[q, 2] + safe
        disc_planes(vx, vy, step_time, horizon, HALF, lanes)
        for j in range(n_lanes):
            k, nx = n_hard + first + j, lanes[5 * LANES + j]
            planes[k, 0], planes[k, 1], planes[k, 2] = nx, lanes[6 * LANES + j], lanes[7 * LANES + j]
            if np.isnan(nx):
                dx, dy, both = lanes[j], lanes[LANES + j], lanes[4 * LANES + j]
                disc_plane(
                    dx, dy, vx, vy, lanes[2 * LANES + j], lanes[3 * LANES + j], both,
                    step_time if dx * dx + dy * dy <= both * both else horizon, HALF,
                    1.0 if body[m] < body[nearest[first + j]] else -1.0, planes[k],
                )  # fmt: skip


@kernel
def add_obstacles(
    w: int,
    walls: Ints,
    is_wall: Flags,
    own: float,
    speed: float,
    options: Any,
    pose: Floats,
    velocity: Floats,
    scene: Scene,
    scratch: Scratch,
) -> int:
    """Write the half-planes of what never moves and of the map; return their number."""
    horizon, count = options.timeHorizonObst, 0
    within = horizon * speed + own
    if walls.shape[0] > 0:
        count = add_walls(w, walls, is_wall, within, own, horizon, pose, velocity, scene, scratch)
    if scene.map_frame[0].body >= 0:
        count = add_map(
            own, horizon, min(within, SIGHT), pose, velocity, scene.map_frame[0], scene.map_squares,
            scratch.sides, scratch.sides_gap, scratch.sides_order, scratch.edge, scratch.planes, count,
        )  # fmt: skip
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
        x, y, within, walls, is_wall, scene.bucket_frame[0], scene.bucket_first[w], scene.bucket_next[w],
        scene.present[w], scene.pose[w], scene.reach[row_of(scene.reach, w)],
        scene.segment_start, n_segments, segments,
        scene.disc_start, scene.disc_count[row_of(scene.disc_count, w)], scene.discs[w],
        scratch.nearby, scratch.parts_gap, scratch.parts, scratch.owners,
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
def command_plans(worlds: Ints, deciding: Ints, model: WorldModel, state: WorldState) -> None:
    """Keep the chosen velocities as plans, and turn them into commands of the drives."""
    for w in worlds:
        for b in deciding:
            if not model.present[w, b]:
                continue
            state.plan[w, b, 0], state.plan[w, b, 1] = state.command[w, b, 0], state.command[w, b, 1]
            to_command(
                model.drive[b],
                state.pose[w, b, 2],
                state.plan[w, b, 0],
                state.plan[w, b, 1],
                model.step_time[0],
                TOLERANCE,
                SLOW,
                model.velocity_max[row_of(model.velocity_max, w), b, 1],
                state.command[w, b],
            )
