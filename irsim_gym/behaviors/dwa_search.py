"""The search of the dynamic window approach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from irsim_gym.arraytypes import BodyOutline, Flags, Floats, Ints, Records
from irsim_gym.behaviors.local_way import LocalWays, distance_from_way, lay_way, point_ahead
from irsim_gym.behaviors.rollouts import (
    LANES,
    Twist,
    Wheels,
    command_window,
    find_nearest,
    gap_at,
    lay_poses,
    own_outline,
    place_at,
    spread_over,
    thin_out,
    twist_of,
    wheels_of,
)
from irsim_gym.behaviors.steering import clear_command, goal_offset
from irsim_gym.jit import kernel
from irsim_gym.structs import Struct
from irsim_gym.world.model import ACKERMANN, DIFFERENTIAL, WorldModel
from irsim_gym.world.own_scan import OwnScan, find_hits
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

BOTH = 2
"""Who has turned on the spot to both sides."""
LETHAL = 253.0
"""Cost of a way beside which something touches the padded footprint, as in ROS's cost maps."""


CLOSE = 1e-9
"""Less than this is rounding."""


@dataclass
class DwaTables(Struct):
    """Memory of one shard.

    Attributes:
        by_rate: Bodies that are commanded by a turn rate although they steer, shape ``(n_bodies,)``.
        hits: Scratch: x and y of what the scan hits [m], shape ``(2, n_beams)``.
        poses: Scratch: a record of type ``POSES``, shape ``(1,)``.
        way: Scratch: x and y of the path ahead [m], shape ``(2, n_points)``.
        ways: The paths over the map.
        origin: Where each member was when it last had moved so far that it may turn on the spot to both sides [m], NaN
            at first; shape ``(n_worlds, n_members, 2)``.
        turned: To which side it has turned on the spot since then: 1 left, -1 right, 0 neither, BOTH or -BOTH both, left
            or right last; shape ``(n_worlds, n_members)``.
    """

    by_rate: Flags
    hits: Floats
    poses: Records
    way: Floats
    ways: LocalWays
    origin: Floats
    turned: Ints


class Task(NamedTuple):
    """What a body has to do, in its own frame.

    Attributes:
        wheels: How it moves.
        outline: Its outline.
        reach: Radius that holds it [m].
        padding: Nearer to something than this a way touches it [m].
        n_hits: Number of points that it sees.
        n_way: Number of points of the path.
        ahead_x: The point ahead on the path [m].
        ahead_y: The point ahead on the path [m].
        forward: How far ahead of the body the end of a way is measured [m].
        goal_radius: Nearer to the end of the path than this it has arrived [m].
    """

    wheels: Wheels
    outline: BodyOutline
    reach: float
    padding: float
    n_hits: int
    n_way: int
    ahead_x: float
    ahead_y: float
    forward: float
    goal_radius: float


@kernel
def decide_dwa(
    worlds: Ints, members: Ints, params: Any, scan: OwnScan, model: WorldModel, state: WorldState, tables: DwaTables
) -> None:
    """Write the commands of bodies that look for the best way within their dynamic window."""
    for w in worlds:
        for k in range(members.shape[0]):
            b, options = members[k], params[k]
            clear_command(state, w, b)
            dx, dy = goal_offset(state, w, b)
            far, near = np.sqrt(dx * dx + dy * dy), model.goal_threshold[row_of(model.goal_threshold, w), b]
            if not model.has_goal[b] or not model.present[w, b] or far < near:
                continue
            wheels = wheels_of(model, state, w, b, tables.by_rate[b])
            n_way = lay_way(state, tables.ways, w, b, tables.way)
            n_hits = find_hits(scan, w, k, options.obstacle_range, tables.hits)
            n_hits = thin_out(tables.hits, n_hits, options.spacing)
            ahead_x, ahead_y = point_ahead(tables.way, n_way, options.lookahead)
            outline, reach = own_outline(model, w, b), model.reach[row_of(model.reach, w), b]
            forward = min(options.forward_point, far) if wheels.drive in (DIFFERENTIAL, ACKERMANN) else 0.0
            task = Task(wheels, outline, reach, 0.0, n_hits, n_way, ahead_x, ahead_y, forward, near)
            task = Task(
                wheels, outline, reach, bearable_gap(task, options, tables), n_hits, n_way, ahead_x, ahead_y, forward, near
            )
            note_move(state, w, b, options.oscillation_distance, tables)
            command = state.command[w, b]
            command[0], command[1] = best_command(task, options, model, state, w, b, tables)
            if wheels.drive == DIFFERENTIAL and command[0] == 0.0 and command[1] != 0.0:
                note_turn(tables, w, tables.ways.row[b], 1 if command[1] > 0.0 else -1)


@kernel
def note_move(state: WorldState, w: int, b: int, distance: float, tables: DwaTables) -> None:
    """Forget to which sides a body has turned on the spot once it has moved so far [m]."""
    m = tables.ways.row[b]
    dx, dy = state.pose[w, b, 0] - tables.origin[w, m, 0], state.pose[w, b, 1] - tables.origin[w, m, 1]
    if not dx * dx + dy * dy <= distance * distance:
        tables.origin[w, m, 0], tables.origin[w, m, 1] = state.pose[w, b, 0], state.pose[w, b, 1]
        tables.turned[w, m] = 0


@kernel
def note_turn(tables: DwaTables, w: int, m: int, side: int) -> None:
    """Write that a member turns on the spot, to the left (1) or the right (-1)."""
    before = tables.turned[w, m]
    if before == 0:
        tables.turned[w, m] = side
    elif before == -side:
        tables.turned[w, m] = BOTH * side


@kernel
def bearable_gap(task: Task, options: Any, tables: DwaTables) -> float:
    """Return how near a way may come to something [m]: by the padding, or as near as the body is now."""
    lay_poses((0.0, 0.0, 0.0), 0, 0.0, tables.poses[0])
    find_nearest(tables.hits, task.n_hits, tables.poses[0])
    padding = options.footprint_padding
    return min(gap_at(task.outline, task.reach, padding, tables.hits, task.n_hits, tables.poses[0], 0), padding) - CLOSE


@kernel
def best_command(
    task: Task, options: Any, model: WorldModel, state: WorldState, w: int, b: int, tables: DwaTables
) -> tuple[float, float]:
    """Return the admissible command whose way costs least; without any, that to escape."""
    step, rolls = model.step_time[0], task.wheels.drive in (DIFFERENTIAL, ACKERMANN)
    low, high = command_window(model, state, w, b, 0, step)
    least, most = command_window(model, state, w, b, 1, step)
    limits = model.acceleration_limit[row_of(model.acceleration_limit, w), b]
    spot, turned = task.wheels.drive == DIFFERENTIAL and low <= 0.0 <= high, tables.turned[w, tables.ways.row[b]]
    if rolls:
        low = max(low, options.min_speed)
        high = max(low, high)
    best, first, second = np.inf, options.escape_speed if rolls else 0.0, 0.0
    n_first, n_second = options.samples[0], options.samples[1]
    for i in range(n_first + int(spot)):
        if i == n_first and abs(turned) == BOTH and best < np.inf:
            break
        one = spread_over(low, high, i, n_first) if i < n_first else 0.0
        for j in range(n_second):
            two = spread_over(least, most, j, n_second)
            if rolls and one == 0.0 and (i < n_first or abs(two) < options.min_turn_rate):
                continue
            if rolls and one == 0.0 and abs(turned) == BOTH and two * turned < 0.0:
                continue
            needed = options.free_time
            if np.isnan(needed):
                needed = step + max(stop_time(one, limits[0]), 0.0 if task.wheels.drive == ACKERMANN else stop_time(two, limits[1]))
            cost = way_cost(task, options, twist_of(task.wheels, one, two), needed, tables)
            if cost < best:
                best, first, second = cost, one, two
    return first, second


@kernel
def stop_time(speed: float, deceleration: float) -> float:
    """Return for how long the way of stopping could be driven at full speed [s].

    Fox et al.: a speed v is admissible if v <= sqrt(2 d a), with the distance d up to a contact and the deceleration a:
    if that is not nearer in time than v / (2 a).
    """
    return abs(speed) / (2.0 * deceleration) if deceleration > 0.0 else np.inf


@kernel
def way_cost(task: Task, options: Any, twist: Twist, needed: float, tables: DwaTables) -> float:
    """Return what a way costs, infinite if it is not free as long as needed [s].

    Reads: tables (hits, poses, way).
    """
    step, horizon, padding = options.sim_granularity, options.sim_time, options.footprint_padding
    limit, least, poses = padding + options.inflation_radius, padding + options.inflation_radius, tables.poses[0]
    goal_x, goal_y, end = tables.way[0, task.n_way - 1], tables.way[1, task.n_way - 1], horizon
    obstacle, saved = 0.0, 0.0
    for i in range(int(np.ceil(max(horizon, needed) / step - CLOSE))):
        if i % LANES == 0:
            lay_poses(twist, i, step, poses)
            find_nearest(tables.hits, task.n_hits, poses)
        k = i % LANES
        gap = gap_at(task.outline, task.reach, limit, tables.hits, task.n_hits, poses, k)
        if gap < task.padding:
            if i * step < needed:
                return np.inf
            if i * step < horizon:
                end, obstacle = i * step, LETHAL * (2.0 - i * step / horizon)
            break
        if (i + 1) * step > horizon + CLOSE:
            continue
        least = min(least, gap)
        dx, dy = goal_x - poses.x[k], goal_y - poses.y[k]
        if dx * dx + dy * dy < task.goal_radius * task.goal_radius:
            end = (i + 1) * step
            saved = (horizon - end) * np.sqrt(twist[0] * twist[0] + twist[1] * twist[1])
            break
    if obstacle == 0.0 and least < limit:
        obstacle = LETHAL * np.exp(-options.cost_scaling * max(least - padding, 0.0))
    x, y, cosine, sine = place_at(twist, end)
    x, y = x + task.forward * cosine, y + task.forward * sine
    dx, dy = task.ahead_x - x, task.ahead_y - y
    path, goal = distance_from_way(tables.way, task.n_way, x, y), np.sqrt(dx * dx + dy * dy) - saved
    return float(options.obstacle_weight * obstacle + options.path_weight * path + options.goal_weight * goal)
