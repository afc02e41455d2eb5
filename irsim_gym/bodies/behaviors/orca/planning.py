"""The choice of velocities by the members of an ORCA group."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from irsim_gym.bodies.behaviors.orca.crowd import Crowd, find_nearest, sort_members
from irsim_gym.bodies.behaviors.orca.lines import HALF, LANES, Other, disc_plane, disc_planes, standing_plane
from irsim_gym.bodies.behaviors.orca.map import SIGHT, add_map
from irsim_gym.bodies.behaviors.orca.neighbors import OrcaObstacles, find_walls
from irsim_gym.bodies.behaviors.orca.walls import add_edge, see_edge
from irsim_gym.bodies.behaviors.shared.steering import Turning, goal_offset, to_command
from irsim_gym.bodies.behaviors.shared.surroundings import Ego
from irsim_gym.simulator.geometry.linear_program import choose, set_plane
from irsim_gym.simulator.world.names import DIFFERENTIAL, Ints, Model, Records, State, Struct, Vector, kernel, row_of

AT_GOAL = 0.1
"""Distance from its goal below which an omnidirectional body prefers to stand still [m]."""

TOLERANCE = 0.1
"""Angle below which a differential body does not turn [rad]."""

SLOW = 0.02
"""Speed below which a differential body does not move [m/s]."""

HELD = 0.1
"""Share of its maximum speed below which a body's plan counts as held up by others."""


@dataclass
class OrcaTables(Struct):
    """The tables for the decisions of a group, with scratch memory of one shard.

    Attributes:
        deciding: The members whose commands are written, shape ``(n_deciding,)``.
        crowd: The members.
        obstacles: The static obstacles.
        planes: Half-planes of permitted velocities, records of type ``HALF_PLANE``, hard ones first.
        spare: Scratch, as many half-planes.
    """

    deciding: Ints
    crowd: Crowd
    obstacles: OrcaObstacles
    planes: Records
    spare: Records


@kernel
def speed_cap(model: Model, w: int, b: int, most: float) -> float:
    """Return the speed [m/s] that a drive can hold in every direction, no more than ``most`` (NaN: no bound).

    Reads: model (drive, velocity_max).
    """
    fastest = model.velocity_max[row_of(model.velocity_max, w), b]
    speed = fastest[0] if model.drive[b] == DIFFERENTIAL else min(fastest[0], fastest[1])
    # `most == most` is False for NaN.
    return float(max(min(speed, most) if most == most else speed, 0.0))


@kernel
def preferred_velocity(model: Model, state: State, w: int, b: int, speed: float) -> Vector:
    """Return the velocity towards the goal [m/s], 0 without one.

    As in IR-SIM, an omnidirectional body stops near its goal and leans to the axis on which it is faster; a
    differential one always drives at full speed.

    Reads: model (drive, has_goal, velocity_max), state (goal, pose).
    """
    if not model.has_goal[b]:
        return 0.0, 0.0
    dx, dy = goal_offset(state, w, b)
    if model.drive[b] == DIFFERENTIAL:
        angle = np.arctan2(dy, dx)
        return speed * np.cos(angle), speed * np.sin(angle)
    distance, fastest = np.sqrt(dx * dx + dy * dy), model.velocity_max[row_of(model.velocity_max, w), b]
    if distance <= AT_GOAL:
        return 0.0, 0.0
    # The ratio of the axes' limits sets the direction, and `speed` the length.
    vx, vy = fastest[0] * dx / distance, fastest[1] * dy / distance
    length = np.sqrt(vx * vx + vy * vy)
    if length < 1e-9:
        return 0.0, 0.0
    return speed * vx / length, speed * vy / length


@kernel
def is_held(ego: Ego, speed: float) -> bool:
    """Return whether a body is on its way by its plan, but hardly moves."""
    planned2 = ego.vx * ego.vx + ego.vy * ego.vy
    return bool(0.0 < planned2 < HELD * HELD * speed * speed)


@kernel
def plan_velocities(worlds: Ints, params: Any, model: Model, state: State, tables: OrcaTables) -> None:
    """Write the velocities that the members choose, in the world frame, to the first two components of ``command``.

    Reads: model (bucket_frame, disc_count, disc_start, drive, has_goal, heedless, map_disc, map_frame, map_squares,
        present, radius, reach, seen_row, segment_count, segment_start, solid, step_time, velocity_max, watchers), state
        (bucket_first, bucket_next, discs, goal, plan, pose, segments, twist), tables (crowd, obstacles, planes).
    Writes: state (command), tables (crowd, obstacles, planes).
    """
    crowd = tables.crowd
    for w in worlds:
        sort_members(model, state, w, crowd)
        for place in range(crowd.squares.columns * crowd.squares.rows):
            # In the order of the squares; any order gives the same, as plans are kept only once all have chosen.
            for m in range(crowd.starts[place], crowd.starts[place + 1]):
                if crowd.plans[crowd.body[m]]:
                    plan_velocity(model, state, w, m, place, params[0], tables)


@kernel
def plan_velocity(model: Model, state: State, w: int, m: int, place: int, options: Any, tables: OrcaTables) -> None:
    """Write the velocity that member m in square ``place`` chooses.

    Reads: model (bucket_frame, disc_count, disc_start, drive, has_goal, heedless, map_disc, map_frame, map_squares,
        present, radius, reach, seen_row, segment_count, segment_start, solid, step_time, velocity_max, watchers), state
        (bucket_first, bucket_next, discs, goal, plan, pose, segments), tables (crowd, obstacles, planes).
    Writes: state (command), tables (crowd, obstacles, planes).
    """
    b = tables.crowd.body[m]
    pose, planned, radius = state.pose[w, b], state.plan[w, b], model.radius[row_of(model.radius, w), b]
    # By its plan, as the others see it too: a drive that has not reached its plan yet would break the reciprocity.
    ego = Ego(pose[0], pose[1], planned[0], planned[1], radius + options.safe_radius)
    n_near = 0
    if not model.heedless[row_of(model.heedless, w), b]:
        n_near = find_nearest(model, ego, m, place, options.neighborDist, tables.crowd)
    speed = speed_cap(model, w, b, options.maxSpeed)
    n_hard = add_obstacles(model, state, w, b, ego, options.timeHorizonObst, speed, tables)
    add_members(ego, m, n_near, n_hard, options, model.step_time[0], tables)
    wanted_x, wanted_y = preferred_velocity(model, state, w, b, speed)
    if options.sidestep and is_held(ego, speed):
        # A quarter turn to the right.
        wanted_x, wanted_y = wanted_y, -wanted_x
    state.command[w, b, 0], state.command[w, b, 1] = choose(
        tables.planes, n_hard, n_hard + n_near, speed, wanted_x, wanted_y, tables.spare
    )


@kernel
def add_members(ego: Ego, m: int, n_near: int, n_hard: int, options: Any, step_time: float, tables: OrcaTables) -> None:
    """Write the half-planes of the nearest members behind the hard ones. Who overlaps has one step to part.

    Reads: tables (crowd, planes).
    Writes: tables (crowd, planes).
    """
    crowd, planes, lanes, horizon = tables.crowd, tables.planes, tables.crowd.lanes[0], options.timeHorizon
    nearest, moves = crowd.nearest, crowd.moves
    for first in range(0, n_near, LANES):
        n_lanes = min(n_near - first, LANES)
        for j in range(n_lanes):
            q = nearest[first + j]
            lanes.x[j], lanes.y[j] = crowd.x[q] - ego.x, crowd.y[q] - ego.y
            lanes.vx[j], lanes.vy[j] = moves[q].vx, moves[q].vy
            # Both bodies keep the safe radius; that of the own body is in ego.radius.
            lanes.radius[j] = ego.radius + moves[q].radius + options.safe_radius
        disc_planes(ego, step_time, horizon, HALF, lanes)
        for j in range(n_lanes):
            plane = planes[n_hard + first + j]
            set_plane(plane, lanes.nx[j], lanes.ny[j], lanes.least[j])
            # The relative velocity is the centre of the cut-off disc: disc_plane chooses a direction.
            if np.isnan(plane.nx):
                other = Other(lanes.x[j], lanes.y[j], lanes.vx[j], lanes.vy[j], lanes.radius[j])
                overlap = other.x * other.x + other.y * other.y <= other.radius * other.radius
                # Opposite for the two, so that they part to different sides.
                side = 1.0 if crowd.body[m] < crowd.body[nearest[first + j]] else -1.0
                disc_plane(ego, other, step_time if overlap else horizon, HALF, side, plane)


@kernel
def add_obstacles(
    model: Model, state: State, w: int, b: int, ego: Ego, horizon: float, speed: float, tables: OrcaTables
) -> int:
    """Write the half-planes of what never moves and of the map; return their number.

    Reads: model (bucket_frame, disc_count, disc_start, map_disc, map_frame, map_squares, present, reach, seen_row,
        segment_count, segment_start, solid, watchers), state (bucket_first, bucket_next, discs, pose, segments), tables
        (obstacles).
    Writes: tables (obstacles, planes).
    """
    obstacles, planes, count = tables.obstacles, tables.planes, 0
    # No wall farther away can be touched within the horizon.
    within = horizon * speed + ego.radius
    if obstacles.walls.shape[0] > 0:
        n_parts = find_walls(model, state, w, b, within, obstacles)
        count = add_walls(model, state, w, ego, horizon, n_parts, tables)
    if model.map_frame[0].body >= 0:
        count = add_map(model, w, ego, horizon, min(within, SIGHT), obstacles, planes, count)
    return count


@kernel
def add_walls(model: Model, state: State, w: int, ego: Ego, horizon: float, n_parts: int, tables: OrcaTables) -> int:
    """Write the half-planes of the sides and discs that were found, nearest first; return their number.

    Reads: model (segment_count, segment_start, solid), state (discs, segments), tables (obstacles).
    Writes: tables (planes).
    """
    planes, segments, count = tables.planes, state.segments[w], 0
    for i in range(n_parts):
        s = tables.obstacles.parts[i]
        q = tables.obstacles.owners[s]
        if s < segments.shape[0]:
            # Rows beyond the segments are discs.
            n_segments = model.segment_count[row_of(model.segment_count, w), q]
            edge = see_edge(segments, model.segment_start[q], n_segments, s, model.solid[q], ego.x, ego.y)
            count = add_edge(edge, ego, horizon, planes, count)
            continue
        standing_plane(ego, state.discs[w, s - segments.shape[0]], horizon, planes[count])
        count += 1
    return count


@kernel
def command_plans(worlds: Ints, model: Model, state: State, tables: OrcaTables) -> None:
    """Keep the chosen velocities as plans, and turn them into commands of the drives.

    Reads: model (drive, present, step_time, velocity_max), state (command, plan, pose), tables (deciding).
    Writes: state (command, plan).
    """
    for w in worlds:
        # A loop of its own, because all members choose by each other's earlier plans.
        for b in tables.deciding:
            if not model.present[w, b]:
                continue
            plan, command = state.plan[w, b], state.command[w, b]
            plan[0], plan[1] = command[0], command[1]
            limit = model.velocity_max[row_of(model.velocity_max, w), b, 1]
            turning = Turning(model.step_time[0], TOLERANCE, SLOW, limit)
            to_command(model.drive[b], state.pose[w, b, 2], plan[0], plan[1], turning, command)
