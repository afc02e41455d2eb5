"""The search of the dynamic window approach."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from irsim_gym.bodies.behaviors.local_planners import rollouts
from irsim_gym.bodies.behaviors.local_planners.task import (
    CLOSE,
    LETHAL,
    LocalTables,
    LocalTask,
    is_under_way,
    obstacle_cost,
    see_hits,
    task_of,
)
from irsim_gym.bodies.behaviors.local_planners.way import off_way
from irsim_gym.bodies.behaviors.pursuit.motion import window_of
from irsim_gym.bodies.behaviors.shared.steering import clear_command
from irsim_gym.simulator.world.names import ACKERMANN, DIFFERENTIAL, Floats, Ints, Model, OwnScan, State, Struct, kernel
from irsim_gym.simulator.world.twist import Twist

BOTH = 2
"""Value of ``turned`` for turns to both sides."""


@dataclass(repr=False)
class Turns(Struct):
    """The sides to which the members have turned on the spot.

    Attributes:
        origin: Position at which each member last had moved far enough to turn to both sides again [m], initially NaN;
            shape ``(n_worlds, n_members, 2)``.
        turned: Side to which it has turned since then: 1 left, -1 right, 0 neither; BOTH or -BOTH: both sides, last to
            the left or right; shape ``(n_worlds, n_members)``.
    """

    origin: Floats
    turned: Ints


@kernel
def decide_dwa(
    worlds: Ints,
    members: Ints,
    params: Any,
    scan: OwnScan,
    model: Model,
    state: State,
    tables: LocalTables,
    turns: Turns,
) -> None:
    """Write the commands of bodies that look for the best way within their dynamic window.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors), model (acceleration_limit,
        disc_count, disc_start, drive, goal_threshold, has_goal, local_discs, local_segments, present, reach,
        segment_count, segment_start, solid, step_time, velocity_max, velocity_min, wheelbase), state (command, goal,
        pose, steering, twist, velocity), tables (by_rate, hits, poses, way, ways), turns (origin, turned).
    Writes: state (command), tables (hits, poses, way), turns (origin, turned).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b, options = members[k], params[k]
            clear_command(state, w, b)
            if not is_under_way(model, state, w, b):
                continue
            # k counts the members that decide now, m all members of the group, whose paths and turns are kept.
            m, command = tables.ways.row[b], state.command[w, b]
            note_move(turns, w, m, state.pose[w, b], options.oscillation_distance)
            task = task_of(w, b, see_hits(scan, w, k, options, tables.hits), options, model, state, tables)
            command[0], command[1] = best_command(task, options, turns.turned[w, m], tables)
            if task.moving.drive == DIFFERENTIAL and command[0] == 0.0 and command[1] != 0.0:
                note_turn(turns, w, m, 1 if command[1] > 0.0 else -1)


@kernel
def forget_turns(worlds: Ints, turns: Turns) -> None:
    """Forget how the members of some worlds have turned.

    Writes: turns (origin, turned).
    """
    for w in worlds:
        turns.origin[w, :, :] = np.nan
        turns.turned[w, :] = 0


@kernel
def note_move(turns: Turns, w: int, m: int, pose: Floats, distance: float) -> None:
    """Forget to which sides a member has turned on the spot once it has moved so far [m].

    Reads: turns (origin).
    Writes: turns (origin, turned).
    """
    origin = turns.origin[w, m]
    dx, dy = pose[0] - origin[0], pose[1] - origin[1]
    # NaN, the origin of a member that has just begun, fails every comparison and so counts as far away.
    if not dx * dx + dy * dy <= distance * distance:
        origin[0], origin[1], turns.turned[w, m] = pose[0], pose[1], 0


@kernel
def note_turn(turns: Turns, w: int, m: int, side: int) -> None:
    """Write that a member turns on the spot, to the left (1) or the right (-1).

    Reads: turns (turned).
    Writes: turns (turned).
    """
    before = turns.turned[w, m]
    if before == 0:
        turns.turned[w, m] = side
    elif before == -side:
        turns.turned[w, m] = BOTH * side


@kernel
def best_command(task: LocalTask, options: Any, turned: int, tables: LocalTables) -> tuple[float, float]:
    """Return the admissible command whose way costs least; without any, that to escape.

    A body that has turned on the spot to both sides does so no more while it can go on; else it goes on turning to the
    side to which it did last.

    Reads: tables (hits, poses, way).
    Writes: tables (poses).

    Args:
        task: What the body has to do.
        options: Those of the behaviour.
        turned: See ``Turns``.
        tables: What it sees.
    """
    moving, drive = task.moving, task.moving.drive
    (low, high), (least, most) = window_of(moving, 0, moving.velocity[0]), window_of(moving, 1, moving.velocity[1])
    rolls, spot = drive in (DIFFERENTIAL, ACKERMANN), drive == DIFFERENTIAL and low <= 0.0 <= high
    if rolls:
        # If a step cannot reach the minimum speed, only that speed is tried.
        low = max(low, options.min_speed)
        high = max(low, high)
    # What remains if no way is admissible: back off straight, or stand.
    best, first, second = np.inf, options.escape_speed if rolls else 0.0, 0.0
    n_first, n_second = options.samples[0], options.samples[1]
    # Rows of speeds first. One more row, i == n_first, is the turns on the spot of a differential drive.
    for i in range(n_first + int(spot)):
        # Otherwise a body that avoids obstacles strongly turns to and fro before gaps for ever.
        if i == n_first and abs(turned) == BOTH and best < np.inf:
            break
        linear = rollouts.spread_over(low, high, i, n_first) if i < n_first else 0.0
        # Standing turns are that last row for a differential drive, and impossible for a car.
        if rolls and linear == 0.0 and i < n_first:
            continue
        for j in range(n_second):
            two = rollouts.spread_over(least, most, j, n_second)
            if i == n_first and (too_slow(two, least, most, options.min_turn_rate) or turns_back(two, turned)):
                continue
            needed = options.free_time
            if np.isnan(needed):
                # A steering angle need not be undone to stop.
                turning = 0.0 if drive == ACKERMANN else stop_time(two, moving.change[1])
                # The command is executed for a step before braking can begin.
                needed = moving.step + max(stop_time(linear, moving.change[0]), turning)
            cost = way_cost(task, options, rollouts.twist_of(moving, task.facing, linear, two), needed, tables)
            if cost < best:
                best, first, second = cost, linear, two
    return first, second


@kernel
def too_slow(rate: float, least: float, most: float, min_rate: float) -> bool:
    """Return whether a turn on the spot is slower than it has to be [rad/s], though a faster one can be reached."""
    # The fastest turn to this side that a step can reach: one that is slower than the minimum may be all there is, as
    # for a body that stands and gains 0.1 rad/s in a step.
    reached = most if rate > 0.0 else -least
    return abs(rate) < min_rate and (abs(rate) < reached or rate == 0.0)


@kernel
def turns_back(rate: float, turned: int) -> bool:
    """Return whether a turn on the spot is to the other side than the last one, after turns to both sides."""
    return abs(turned) == BOTH and rate * turned < 0.0


@kernel
def stop_time(speed: float, deceleration: float) -> float:
    """Return how long a body would take for its braking distance at its present speed [s].

    A speed v is admissible (Fox et al. 1997, section 4) if v <= sqrt(2 d a), with the distance d up to a contact and
    the deceleration a. Divided by v, this says that the contact is at least v / (2 a) away in time.
    """
    return abs(speed) / (2.0 * deceleration) if deceleration > 0.0 else np.inf


@kernel
def way_cost(task: LocalTask, options: Any, twist: Twist, needed: float, tables: LocalTables) -> float:
    """Return what a way costs, infinite if it is not free as long as needed [s].

    Reads: tables (hits, poses, way).
    Writes: tables (poses).
    """
    step, horizon, poses = options.sim_granularity, options.sim_time, tables.poses[0]
    limit = options.footprint_padding + options.inflation_radius
    least, end, obstacle, saved = limit, horizon, 0.0, 0.0
    speed = np.sqrt(twist[0] * twist[0] + twist[1] * twist[1])
    # Pose i is where the body is after i + 1 steps of granularity. CLOSE keeps rounding from adding one more.
    for i in range(int(np.ceil(max(horizon, needed) / step - CLOSE))):
        k = i % rollouts.LANES
        # Poses are computed and compared with the hits LANES at a time.
        if k == 0:
            rollouts.lay_poses(twist, i, step, poses)
            rollouts.find_nearest(tables.hits, task.n_hits, poses)
        gap = rollouts.gap_at(task.outline, task.reach, limit, tables.hits, task.n_hits, poses, k)
        if gap < task.bearable:
            # The last free pose is the one before, at the time i * step: too early to stop.
            if i * step < needed - CLOSE:
                return np.inf
            if i * step < horizon:
                # The arc ends there, at a cost from 253 (at the horizon) to 506 (at once).
                end, obstacle = i * step, LETHAL * (2.0 - i * step / horizon)
            break
        # Beyond the horizon, poses decide whether the way is admissible, and cost nothing.
        if (i + 1) * step > horizon + CLOSE:
            continue
        least = min(least, gap)
        dx, dy = task.goal_x - poses.x[k], task.goal_y - poses.y[k]
        if dx * dx + dy * dy < task.goal_radius * task.goal_radius:
            end = (i + 1) * step
            # An early arrival is credited with the distance that it could still have driven.
            saved = (horizon - end) * speed
            break
    x, y, cosine, sine = rollouts.place_at(twist, end)
    # The end is measured ahead of a body that rolls: there, where it points changes the distance from the path.
    x, y = x + task.forward * cosine, y + task.forward * sine
    # Projecting onto no more of the path than the arc is long keeps it from skipping to a later part of the path.
    path, reached = off_way(tables.way, task.n_way, (x, y), speed * end + task.forward)
    obstacle = max(obstacle, obstacle_cost(options, least))
    goal = task.length - reached - saved
    return float(options.obstacle_weight * obstacle + options.path_weight * path + options.goal_weight * goal)
