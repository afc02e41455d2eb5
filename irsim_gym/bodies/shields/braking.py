"""Where a body comes to rest: the commands under way, one more, and then a full stop, as its drive executes them."""

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.bodies.shields.tables import ShieldTables
from irsim_gym.bodies.shields.walls import Pose, is_too_near
from irsim_gym.simulator.step.command_limits import hold_speed
from irsim_gym.simulator.world.names import (
    ACKERMANN,
    DIFFERENTIAL,
    OMNI_ANGULAR,
    OMNI_WORLD,
    Model,
    State,
    kernel,
    row_of,
)
from irsim_gym.simulator.world.outline import own_outline

REST = 2e-5
"""A body that goes no farther than this has stopped [m]."""
LONGEST = 10_000
"""A body that does not stand after so many steps counts as one that cannot stop."""


@kernel
def brakes_in_time(
    w: int, k: int, slot: int, n_walls: int, tables: ShieldTables, model: Model, state: State
) -> tuple[bool, float]:
    """Return whether member k can stop in time after the command ``tables.command``, and how far it goes [m].

    What it executes is what the step makes of commands: those under way come first, the lag follows, then the limits.

    Reads: tables (by_rate, command, members, need, now, response, walls), model (acceleration_limit, disc_count,
        disc_start, drive, local_discs, local_segments, reach, segment_count, segment_start, solid, speed_bound,
        step_time, velocity_max, velocity_min, wheelbase), state (pose, steering, velocity).
    Writes: tables (now).

    Args:
        w: The world.
        k: The member.
        slot: Whose scratch memory.
        n_walls: How many walls count.
        tables: The members.
        model: Constants of the worlds.
        state: State of the worlds.
    """
    b, response, now, dt = tables.members[k], tables.response, tables.now[slot], model.step_time[0]
    place, outline, reach = response.place[b], own_outline(model, w, b), model.reach[row_of(model.reach, w), b]
    n, share, dead_band = response.n_pending[w, place], response.share[w, place], response.dead_band[w, place]
    low = model.velocity_min[row_of(model.velocity_min, w), b]
    high = model.velocity_max[row_of(model.velocity_max, w), b]
    sharpest = model.acceleration_limit[row_of(model.acceleration_limit, w), b]
    pose, steering, length = (0.0, 0.0, 0.0), state.steering[w, b], 0.0
    wheelbase = 0.0 if tables.by_rate[k] else model.wheelbase[b]
    for axis in range(3):
        now[axis] = state.velocity[w, b, axis]
    for step in range(LONGEST):
        for axis in range(3):
            asked = tables.command[slot, axis] if step == n else 0.0
            asked = response.pending[w, place, step, axis] if step < n else asked
            asked = asked if np.abs(asked) >= dead_band else 0.0
            asked, change = now[axis] + (asked - now[axis]) * share, sharpest[axis] * dt
            least, most = max(low[axis], now[axis] - change), min(high[axis], now[axis] + change)
            now[axis] = min(max(asked, least), most)
        if model.speed_bound[b]:
            hold_speed(now, high[0])
        ahead, left, rate = twist_of(now, steering, state.pose[w, b, 2] + pose[2], model.drive[b], wheelbase)
        cosine, sine = np.cos(pose[2]), np.sin(pose[2])
        x, y = pose[0] + (cosine * ahead - sine * left) * dt, pose[1] + (sine * ahead + cosine * left) * dt
        following, steering = (x, y, pose[2] + rate * dt), now[1]
        if is_too_near(outline, reach, (pose, following), tables.walls[slot], tables.need[slot], n_walls):
            return False, length
        moves, pose = np.sqrt(ahead * ahead + left * left) * dt, following
        length += moves
        # With a lag, velocities never reach 0, but what is left of the way has a sum: no more than this by the share.
        if step > n and moves + reach * np.abs(rate) * dt < REST * share:
            return True, length
    return False, length


@kernel
def twist_of(velocity: Floats, steering: float, heading: float, drive: int, wheelbase: float) -> Pose:
    """Return velocity ahead and to the left [m/s] and turn rate [rad/s] of a drive in a step.

    Args:
        velocity: What it executes, in its own coordinates, shape ``(3,)``.
        steering: The steering angle of a car in the step before [rad], which it still rolls at.
        heading: Direction of the body's x axis [rad].
        drive: How its command reads, see ``simulator.world.model``.
        wheelbase: Axle distance of a car [m]; 0 if its command has a turn rate.
    """
    first, second = velocity[0], velocity[1]
    if drive == DIFFERENTIAL:
        return first, 0.0, second
    if drive == ACKERMANN:
        if wheelbase > 0.0:
            return first, 0.0, first * np.tan(steering) / wheelbase
        return first, 0.0, second if first != 0.0 else 0.0
    if drive == OMNI_WORLD:
        cosine, sine = np.cos(heading), np.sin(heading)
        return cosine * first + sine * second, cosine * second - sine * first, 0.0
    return first, second, velocity[2] if drive == OMNI_ANGULAR else 0.0
