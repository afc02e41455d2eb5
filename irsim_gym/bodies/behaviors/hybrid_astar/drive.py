"""Drives one body along its path over poses: its speed, and when it plans again."""

import numpy as np

from irsim_gym.bodies.behaviors.hybrid_astar import follow
from irsim_gym.bodies.behaviors.hybrid_astar.plan import TIGHT, find_poses, shape_of
from irsim_gym.bodies.behaviors.hybrid_astar.tables import PoseTables, PoseWay
from irsim_gym.bodies.behaviors.pursuit.motion import MOST_STEPS, Moving, executed, moving_of, roll
from irsim_gym.simulator.cell_paths.outline_room import PoseShape, room_at_pose
from irsim_gym.simulator.paths.clearance import Obstacles
from irsim_gym.simulator.world.names import ACKERMANN, Record, State, kernel

PARTS = 4
"""Number of speeds that are tried, each half of the previous one."""
CLOSE = 0.01
"""Distance from the end of a gear at which the next one begins [m or rad]."""
DRIFT = 0.05
"""Maximum distance from its path at the chosen speed [m], unless the body is farther away already."""
ASTRAY = 0.5
"""Distance from its path above which a body plans again [m]."""
PATIENCE, SOON = 100, 10
"""Number of steps after which a body plans again if it found no path, or cannot follow it."""
KEPT = 0.005
"""Distance from obstacles that a body keeps on its path [m], unless it is closer now."""


@kernel
def motion_of(moving: Moving) -> follow.PoseMotion:
    """Return what a body does now."""
    pose = (moving.pose[0], moving.pose[1], moving.pose[2])
    return follow.PoseMotion(pose, moving.steering, moving.velocity[0], moving.velocity[1])


@kernel
def is_at_rest(moving: Moving, first: float, two: float) -> bool:
    """Return whether a body with these velocities stands still; the second number of a car turns none at rest."""
    return bool(first == 0.0 and (two == 0.0 or moving.drive == ACKERMANN))


@kernel
def stops_in_time(
    obstacles: Obstacles,
    shape: PoseShape,
    moving: Moving,
    way: PoseWay,
    place: follow.OnWay,
    part: float,
    drift: float,
    room: float,
) -> bool:
    """Return whether a body stays clear in a step along its path, and while it brakes to a stop on the path.

    Args:
        obstacles: What is in the way, where it is now.
        shape: The body's outline.
        moving: What it does and can do.
        way: The way.
        place: Where it is on it.
        part: Share of its speed in the first step.
        drift: So far from its way it may get [m].
        room: So far from obstacles it has to stay [m].
    """
    now = motion_of(moving)
    # The first step at the given share of the speed, all others braking.
    for _ in range(MOST_STEPS):
        first, second = follow.command_along(way, place, moving, now, part)
        linear, two = executed(moving, 0, first, now.one), executed(moving, 1, second, now.two)
        x, y, heading, steering = roll(moving, now.pose[0], now.pose[1], now.pose[2], now.steering, linear, two, 0.0)
        now = follow.PoseMotion((x, y, heading), steering, linear, two)
        if room_at_pose(obstacles, shape, now.pose, KEPT) < room:
            return False
        place, part = follow.place_near(way, place, now.pose), 0.0
        if follow.offset_from(way, place, now.pose) > drift:
            return False
        if is_at_rest(moving, linear, two):
            return True
    # Still braking after so many steps, and clear so far.
    return True


@kernel
def is_new(state: State, tables: PoseTables, w: int, m: int, b: int) -> bool:
    """Return whether a member's goal is not where its way leads; a heading that is NaN is one like any other.

    Reads: state (goal), tables (goal).
    """
    goal, planned = state.goal[w, b], tables.goal[w, m]
    same = goal[0] == planned[0] and goal[1] == planned[1]
    return bool(not same or not (goal[2] == planned[2] or (goal[2] != goal[2] and planned[2] != planned[2])))


@kernel
def drive_poses(
    standing: Obstacles, everything: Obstacles, options: Record, tables: PoseTables, slot: int, b: int
) -> None:
    """Write the command of one body, and look for its way where it has none to its goal or cannot follow it.

    Reads: tables (by_rate, cell, count, discs, goal, grid, memory, moves, piece, pieces, retry, segments, share).
    Writes: standing, tables (count, goal, piece, pieces, retry, share).
    """
    model, state, w, m = standing.model, standing.state, standing.w, options.index
    moving, shape = moving_of(model, state, w, b, tables.by_rate[m]), shape_of(model, w, b, tables, slot)
    looks = is_new(state, tables, w, m, b)
    # First by the known way; if that is no good and it is time, once more by a new one.
    for _ in range(2):
        if looks:
            find_poses(standing, options, moving, tables, slot, b)
            tables.retry[w, m] = state.step[w] + (SOON if tables.count[w, m] > 0 else PATIENCE)
        good = False
        if tables.count[w, m] > 0:
            good, first, second = go_on(standing, everything, shape, moving, tables, m)
            state.command[w, b, 0], state.command[w, b, 1] = first, second
        if good or looks or state.step[w] < tables.retry[w, m]:
            return
        looks = True


@kernel
def go_on(
    standing: Obstacles, everything: Obstacles, shape: PoseShape, moving: Moving, tables: PoseTables, m: int
) -> tuple[bool, float, float]:
    """Return whether a way can be followed, and the command for it; a body waits for what moves.

    Reads: tables (count, piece, pieces, share).
    Writes: shape, tables (piece, share).
    """
    w = standing.w
    way, now = PoseWay(tables.pieces[w, m], tables.count[w, m]), motion_of(moving)
    place = follow.place_near(way, follow.OnWay(tables.piece[w, m], tables.share[w, m]), now.pose)
    ends = follow.left_in_gear(way, place) < CLOSE
    if ends and place.piece + 1 < way.n_pieces:
        # At the end of a gear, the body goes on with the next one; place_near never leaves a gear by itself.
        place, ends = follow.place_near(way, follow.OnWay(place.piece + 1, 0.0), now.pose), False
    tables.piece[w, m], tables.share[w, m] = place.piece, place.share
    offset, part = follow.offset_from(way, place, now.pose), 1.0
    is_blocked = ends or offset > ASTRAY
    # A body that is off its way, or close to something, already must only not make it worse.
    drift, room = max(DRIFT, offset), min(TIGHT * room_at_pose(everything, shape, now.pose, KEPT), KEPT)
    for k in range(0 if is_blocked else PARTS + 1):
        # The last attempt: at the lowest speed, however far from the way.
        if k == PARTS:
            drift = np.inf
        if stops_in_time(everything, shape, moving, way, place, part, drift, room):
            first, second = follow.command_along(way, place, moving, now, part)
            return True, first, second
        part *= 0.5 if k < PARTS - 1 else 1.0
    # What stands blocks the way for good, so that it is planned anew; for what moves, the body waits.
    if not is_blocked and is_at_rest(moving, now.one, now.two):
        is_blocked = not stops_in_time(standing, shape, moving, way, place, part, drift, room)
    first, second = follow.command_along(way, place, moving, now, 0.0)
    return not is_blocked, first, second
