"""Where a body goes: the commands under way, one that is tried, and then a full stop, as its drive executes them."""

import numpy as np

from irsim_gym.bodies.shields.tables import ShieldTables
from irsim_gym.bodies.shields.walls import is_too_near
from irsim_gym.simulator.step.command_limits import hold_speed
from irsim_gym.simulator.world.names import Model, State, kernel, own_outline, row_of
from irsim_gym.simulator.world.twist import body_twist

REST = 2e-5
"""A body that goes no farther than this has stopped [m]."""
LONGEST = 10_000
"""A body that does not stand after so many steps counts as one that cannot stop."""


@kernel
def begin_rolling(w: int, k: int, slot: int, tables: ShieldTables, state: State) -> None:
    """Begin with the present velocity of member k, at the origin of its own frame.

    Reads: tables (members), state (steering, velocity).
    Writes: tables (now, place).
    """
    for axis in range(3):
        tables.now[slot, axis], tables.place[slot, axis] = state.velocity[w, tables.members[k], axis], 0.0
    tables.place[slot, 3] = state.steering[w, tables.members[k]]


@kernel
def roll_on(
    w: int, k: int, slot: int, step: int, hold: int, tables: ShieldTables, model: Model, state: State
) -> tuple[float, float]:
    """Advance ``tables.now`` and ``tables.place`` by a step; return how far the body goes [m] and turns [rad].

    What it executes is what a step makes of commands: those under way come first, then ``tables.command`` for ``hold``
    steps, then zeros; the lag follows, then the limits.

    Reads: tables (by_rate, command, members, now, place, response), model (acceleration_limit, drive, speed_bound,
        step_time, velocity_max, velocity_min, wheelbase), state (pose).
    Writes: tables (now, place).
    """
    b, response, dt = tables.members[k], tables.response, model.step_time[0]
    now, at, a = tables.now[slot], tables.place[slot], response.place[b]
    n, share, dead_band = response.n_pending[w, a], response.share[w, a], response.dead_band[w, a]
    low = model.velocity_min[row_of(model.velocity_min, w), b]
    high = model.velocity_max[row_of(model.velocity_max, w), b]
    sharpest = model.acceleration_limit[row_of(model.acceleration_limit, w), b]
    for axis in range(3):
        command = tables.command[slot, axis] if step < n + hold else 0.0
        command = response.pending[w, a, step, axis] if step < n else command
        command = command if np.abs(command) >= dead_band else 0.0
        command, change = now[axis] + (command - now[axis]) * share, sharpest[axis] * dt
        least, most = max(low[axis], now[axis] - change), min(high[axis], now[axis] + change)
        now[axis] = min(max(command, least), most)
    if model.speed_bound[b]:
        hold_speed(now, high[0])
    wheelbase = 0.0 if tables.by_rate[k] else model.wheelbase[b]
    heading = state.pose[w, b, 2] + at[2]
    ahead, left, rate = body_twist(now, at[3], np.cos(heading), np.sin(heading), model.drive[b], wheelbase)
    cosine, sine = np.cos(at[2]), np.sin(at[2])
    at[0] += (cosine * ahead - sine * left) * dt
    at[1] += (sine * ahead + cosine * left) * dt
    at[2] += rate * dt
    at[3] = now[1]
    return np.sqrt(ahead * ahead + left * left) * dt, np.abs(rate) * dt


@kernel
def brakes_in_time(
    w: int, k: int, slot: int, n_walls: int, tables: ShieldTables, model: Model, state: State
) -> tuple[bool, float]:
    """Return whether member k can stop before all walls after the command ``tables.command``, and how far it goes [m].

    Reads: tables (by_rate, command, members, need, now, place, response, walls), model (acceleration_limit, disc_count,
        disc_start, drive, local_discs, local_segments, reach, segment_count, segment_start, solid, speed_bound,
        step_time, velocity_max, velocity_min, wheelbase), state (pose, steering, velocity).
    Writes: tables (now, place, walls).

    Args:
        w: The world.
        k: The member.
        slot: Whose scratch memory.
        n_walls: How many walls count.
        tables: The members.
        model: Constants of the worlds.
        state: State of the worlds.
    """
    b, at, length = tables.members[k], tables.place[slot], 0.0
    outline, reach, a = own_outline(model, w, b), model.reach[row_of(model.reach, w), b], tables.response.place[b]
    begin_rolling(w, k, slot, tables, state)
    for step in range(LONGEST):
        before = (at[0], at[1], at[2])
        moves, turns = roll_on(w, k, slot, step, 1, tables, model, state)
        length += moves
        way = (before, (at[0], at[1], at[2]))
        if is_too_near(outline, reach, way, tables.walls[slot], tables.need[slot], n_walls):
            return False, length
        # With a lag, velocities never reach 0, but what is left of the way has a sum: no more than this by the share.
        if step > tables.response.n_pending[w, a] and moves + reach * turns < REST * tables.response.share[w, a]:
            return True, length
    return False, length
