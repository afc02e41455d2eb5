"""Follows a path by commands after which the body can still stop before it touches anything."""

from typing import NamedTuple

import numpy as np

from irsim_gym.bodies.behaviors.pursuit.commands import braking_command, command_to, turn_command
from irsim_gym.bodies.behaviors.pursuit.formulas import lookahead_distance
from irsim_gym.bodies.behaviors.pursuit.motion import Command, Moving, can_stop
from irsim_gym.bodies.behaviors.pursuit.tables import TIGHT
from irsim_gym.bodies.behaviors.pursuit.way import WINDOW, place_on_way, point_at_distance, remaining_length
from irsim_gym.simulator.geometry.angles import wrap_below
from irsim_gym.simulator.paths.clearance import Obstacles, room_at, way_is_free
from irsim_gym.simulator.world.names import ACKERMANN, DIFFERENTIAL, Floats, Point, Record, kernel

TRIES = 5
"""Number of points ahead that are tried, each half as far away as the previous one."""
SLOWEST = 0.05
"""Minimum share of the regulated speed that is tried."""
STRAIGHT = 1e-3
"""Bearing up to which a body faces a point ahead, and need not turn on the spot first [rad]."""
BEHIND, AHEAD = 0.5 * np.pi, 0.1
"""A car that can drive back begins to when its way leads behind it, beyond BEHIND, and stops within AHEAD [rad]."""
BACK_STEPS = 15
"""Number of steps for which it drives back at a time."""
SIGHT = 1.0
"""Obstacles farther away than this do not matter to how fast a body drives [m], unless ``proximity`` is more."""


class Course(NamedTuple):
    """A path, and the body's place on it.

    Attributes:
        points: Points of the path [m], shape ``(n_points, 2)``.
        n_points: Number of points, at least 2.
        side: Segment of the path on which the body was.
        margin: Clearance of the body's surface from standing obstacles along the path [m].
        goes_on: Whether the path continues beyond its last point, so that the body does not slow down.
    """

    points: Floats
    n_points: int
    side: int
    margin: float
    goes_on: bool


@kernel
def follow(
    standing: Obstacles, everything: Obstacles, options: Record, reach: float, moving: Moving, course: Course, back: int
) -> tuple[bool, int, int, Command]:
    """Return whether the way can be followed, the side where the body is, how long it drives back, and its command.

    The body aims at a point ahead to which the straight way is free. If it could not stop on the arc to it before it
    touches something, nearer points are tried, then slower speeds, and at last it stops. Where no point ahead is free,
    the way cannot be followed from where the body is.

    Reads: standing (blocks, cells, model, state, w), everything (blocks, cells, model, state, w).

    Args:
        standing: What stands in the way.
        everything: That, and what moves, where it is now.
        options: Those of ``Pursuit``.
        reach: Radius of the body [m].
        moving: What it does and can do.
        course: The way.
        back: Steps for which it drives back.
    """
    position, way, count = (moving.pose[0], moving.pose[1]), course.points, course.n_points
    side, near = place_on_way(way, count, course.side, position)
    # Only a body that was put elsewhere can be so far from its way.
    if abs(near[0] - position[0]) > WINDOW or abs(near[1] - position[1]) > WINDOW:
        return False, side, 0, braking_command(moving)
    remaining = np.inf if course.goes_on else remaining_length(way, count, side, near)
    room = room_at(everything, position, reach + max(options.proximity, SIGHT)) - reach
    # The body grown by half of the room that the way keeps, or that there is now. One that touches something already
    # must not get nearer.
    radius = reach + 0.5 * min(course.margin, room) if room > 0.0 else TIGHT * (reach + room)
    # Moving by less than this, the grown body touches nothing: can_stop need not look.
    slack = max(room + reach - radius, 0.0)
    speed = np.abs(moving.velocity[0])
    if moving.drive not in (DIFFERENTIAL, ACKERMANN):
        speed = np.sqrt(speed * speed + moving.velocity[1] * moving.velocity[1])
    distance, is_reached, target = lookahead_distance(options, speed), False, position
    for _ in range(TRIES):
        point = point_at_distance(way, count, side, position, distance)
        distance *= 0.5
        if not way_is_free(standing, radius, position, point):
            continue
        is_reached, target = True, point
        if wants_back(moving, point, back):
            break
        command = command_to(options, moving, point, room, remaining, 1.0)
        if can_stop(everything, radius, slack, moving, command):
            return True, side, 0, command
    if not is_reached:
        return False, side, 0, braking_command(moving)
    backs, command = careful_command(everything, options, radius, slack, moving, target, room, remaining)
    # A count of steps: it goes on driving back while it counts, see wants_back.
    more = back - 1 if back > 0 else BACK_STEPS
    return True, side, more if backs else 0, command


@kernel
def bearing_to(moving: Moving, target: Point) -> float:
    """Return the bearing of a point [rad], without its sign."""
    dx, dy = target[0] - moving.pose[0], target[1] - moving.pose[1]
    return float(np.abs(wrap_below(np.arctan2(dy, dx) - moving.pose[2])))


@kernel
def wants_back(moving: Moving, target: Point, back: int) -> bool:
    """Return whether a car is to drive back: the point lies behind it, or not ahead yet while it does so."""
    if moving.drive != ACKERMANN or moving.low[0] >= 0.0:
        return False
    return bool(bearing_to(moving, target) > (AHEAD if back > 0 else BEHIND))


@kernel
def careful_command(
    obstacles: Obstacles, options: Record, radius: float, slack: float, moving: Moving, target: Point,
    room: float, remaining: float,
) -> tuple[bool, Command]:  # fmt: skip
    """Return whether a body that cannot go on as it should drives back, and its command.

    A car drives back if it can; others, and it, go slowly; a differential drive turns on the spot; else it stops.

    Reads: obstacles (blocks, cells, model, state, w).

    Args:
        obstacles: What is in the way.
        options: Those of ``Pursuit``.
        radius: Radius of the body [m].
        slack: So far the body may go in any direction [m].
        moving: The body.
        target: A point ahead to which the straight way is free [m].
        room: Distance of the body's surface from the nearest obstacle [m].
        remaining: What remains of the way [m].
    """
    if moving.drive == ACKERMANN and moving.low[0] < 0.0:
        command = command_to(options, moving, target, room, remaining, -0.5)
        if can_stop(obstacles, radius, slack, moving, command):
            return True, command
    # The full share has been tried by the caller.
    share = 0.5
    while share >= SLOWEST:
        command = command_to(options, moving, target, room, remaining, share)
        if can_stop(obstacles, radius, slack, moving, command):
            return False, command
        share *= 0.5
    if moving.drive == DIFFERENTIAL and bearing_to(moving, target) > STRAIGHT:
        command = turn_command(moving, target)
        if can_stop(obstacles, radius, slack, moving, command):
            return False, command
    return False, braking_command(moving)
