"""Drives one body in pursuit: whether it has to drive, its obstacles, and its command."""

from irsim_gym.bodies.behaviors.pursuit.commands import spin
from irsim_gym.bodies.behaviors.pursuit.follow import Course, follow
from irsim_gym.bodies.behaviors.pursuit.motion import moving_of
from irsim_gym.bodies.behaviors.pursuit.tables import MOST_POINTS, PATIENCE, PursuitTables, find_way
from irsim_gym.bodies.behaviors.shared.surroundings import is_seen
from irsim_gym.simulator.geometry.angles import wrap_below
from irsim_gym.simulator.paths.clearance import Obstacles
from irsim_gym.simulator.world.model import DIFFERENTIAL, OMNI_ANGULAR, STATE, Model
from irsim_gym.simulator.world.names import Flags, Record, State, kernel, row_of


@kernel
def is_under_way(model: Model, state: State, w: int, b: int) -> bool:
    """Return whether a body has somewhere to go and may go there.

    Reads: model (has_goal, present), state (arrived, goal, stopped).
    """
    if not model.has_goal[b] or not model.present[w, b] or state.stopped[w, b] or state.arrived[w, b]:
        return False
    # NaN, which does not equal itself, is no goal.
    return bool(state.goal[w, b, 0] == state.goal[w, b, 0])


@kernel
def turns_at_goal(model: Model, state: State, w: int, b: int) -> bool:
    """Return whether a body that is to arrive with a heading is near enough to its goal to turn there, if it can.

    Reads: model (arrive_mode, drive, goal_threshold), state (goal, pose).
    """
    dx, dy = state.goal[w, b, 0] - state.pose[w, b, 0], state.goal[w, b, 1] - state.pose[w, b, 1]
    # Half of the threshold, since arrival counts metres and radians together.
    near = 0.5 * model.goal_threshold[row_of(model.goal_threshold, w), b]
    if model.arrive_mode[b] != STATE or model.drive[b] not in (DIFFERENTIAL, OMNI_ANGULAR):
        return False
    return bool(dx * dx + dy * dy < near * near and state.goal[w, b, 2] == state.goal[w, b, 2])


@kernel
def mark_moving(model: Model, w: int, body: int, target_roles: int, standing: Flags, everything: Flags) -> None:
    """Write what stands in the way of a body, and what moves.

    Reads: model (heedless, movable, present, role, seen_row, stands, unobstructed, watchers).
    Writes: everything.
    """
    for b in range(standing.shape[0]):
        moves = not model.stands[b] and not model.unobstructed[b] and is_seen(model, w, body, b, target_roles)
        everything[b] = standing[b] or moves


@kernel
def pursue(
    standing: Obstacles, everything: Obstacles, options: Record, tables: PursuitTables, slot: int, b: int
) -> None:
    """Write the command of one body, and look for its way where it has none to its goal or cannot follow it.

    Reads: tables (back, by_rate, coarse, count, fine, goal, margin, points, retry, side, whole).
    Writes: standing, tables (back, coarse, count, fine, goal, margin, points, retry, side, whole).
    """
    model, state, w, m = standing.model, standing.state, standing.w, options.index
    goal, position = (state.goal[w, b, 0], state.goal[w, b, 1]), (state.pose[w, b, 0], state.pose[w, b, 1])
    reach, moving = model.reach[row_of(model.reach, w), b], moving_of(model, state, w, b, tables.by_rate[m])
    # The goal NaN, without a way, equals none.
    is_new = not (tables.goal[w, m, 0] == goal[0] and tables.goal[w, m, 1] == goal[1])
    # The last stored side of a way that was too long for the memory.
    is_new = is_new or (not tables.whole[w, m] and tables.side[w, m] >= MOST_POINTS - 2)
    if turns_at_goal(model, state, w, b):
        axis = 1 if moving.drive == DIFFERENTIAL else 2
        state.command[w, b, axis] = spin(moving, axis, wrap_below(state.goal[w, b, 2] - state.pose[w, b, 2]))
        return
    # First by the known way; if that is no good and it is time, once more by a new one.
    for _ in range(2):
        if is_new:
            find_way(standing, reach, options.clearance, (position, goal), tables, slot, m)
            tables.retry[w, m] = state.step[w] + PATIENCE
        if tables.count[w, m] > 0:
            # No slowing down at the end of a part of a way, or at a waypoint before the last.
            goes_on = not tables.whole[w, m] or state.waypoint[w, b] + 1 < state.waypoint_end[w, b]
            course = Course(tables.points[w, m], tables.count[w, m], tables.side[w, m], tables.margin[w, m], goes_on)
            good, side, back, command = follow(standing, everything, options, reach, moving, course, tables.back[w, m])
            tables.side[w, m], tables.back[w, m] = side, back
            state.command[w, b, 0], state.command[w, b, 1], state.command[w, b, 2] = command
            if good:
                return
        if is_new or state.step[w] < tables.retry[w, m]:
            return
        is_new = True
