"""Pursuit: the shortest way on the map, followed by regulated pure pursuit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.arraytypes import CellMaps, Flags, Ints, Record
from irsim_gym.behaviors import renewal
from irsim_gym.behaviors.pursuit_commands import spin
from irsim_gym.behaviors.pursuit_follow import Course, follow
from irsim_gym.behaviors.pursuit_motion import moving_of
from irsim_gym.behaviors.pursuit_tables import MOST_POINTS, PATIENCE, PursuitTables, find_way, forget_ways
from irsim_gym.behaviors.steering import clear_command
from irsim_gym.behaviors.surroundings import is_seen
from irsim_gym.geometry.angles import wrap_below
from irsim_gym.jit import kernel
from irsim_gym.paths.clearance import Obstacles, mark_standing
from irsim_gym.scenario.options import kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import DIFFERENTIAL, OMNI_ANGULAR, STATE, WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState


@kind
class Pursuit:
    """Find the shortest way to the goal past all that stands, and follow it by regulated pure pursuit.

    A body counts as the disc about its origin that holds it. What moves is not on the map: the body waits for what is
    close ahead, and does not go around it.
    """

    only_kernels: ClassVar[bool] = True
    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni", "omni_angular", "acker")
    reads_neighbors: ClassVar[bool] = False

    wander: bool = option(False, meaning="Draw a new random goal after each arrival.")
    loop: bool = option(False, meaning="Begin again with the first goal after the last.")
    target_roles: Literal["all", "robot", "obstacle"] = option(
        "all", meaning="Which other bodies that move it stops for; all that stand are on the map."
    )
    range_low: tuple[float, float, float] = option(
        (0.0, 0.0, -np.pi), unit="m, m, rad", meaning="Lower bounds of a wandering body's goals."
    )
    range_high: tuple[float, float, float] = option(
        (10.0, 10.0, np.pi), unit="m, m, rad", meaning="Upper bounds of a wandering body's goals."
    )
    wander_goals: renewal.WanderGoals = renewal.GOALS
    clearance: float = option(
        0.1,
        ge=0.0,
        unit="m",
        meaning="Distance that the way keeps from obstacles; half, a quarter or nothing of it where no way does.",
    )
    cell: float | None = option(
        None,
        gt=0.0,
        unit="m",
        meaning="Cell size of the grid on which ways are found; default: half the radius of the body.",
        consequence="Large: ways through narrow gaps are missed.",
    )
    speed: float | None = option(None, gt=0.0, unit="m/s", meaning="Greatest speed; by default the drive's.")
    lookahead_time: float = option(
        0.6, ge=0.0, unit="s", meaning="The point aimed at is as far ahead as the body drives in this time."
    )
    lookahead_min: float = option(0.3, gt=0.0, unit="m", meaning="Least distance of that point.")
    lookahead_max: float | None = option(None, gt=0.0, unit="m", meaning="Greatest distance of that point.")
    min_radius: float = option(
        0.5, ge=0.0, unit="m", meaning="Curves of a smaller radius are driven slower, in proportion to the radius."
    )
    proximity: float = option(
        0.1,
        ge=0.0,
        unit="m",
        meaning="Nearer to an obstacle it drives slower, in proportion to the distance.",
    )
    proximity_gain: float = option(1.0, gt=0.0, le=1.0, meaning="Factor of that: the lower the slower.")
    min_speed: float = option(0.25, ge=0.0, unit="m/s", meaning="Curves and obstacles never slow it below this.")
    approach: float = option(
        0.6,
        ge=0.0,
        unit="m",
        meaning="From here on it slows down for the goal, in proportion to what is left.",
    )
    approach_speed: float = option(0.05, ge=0.0, unit="m/s", meaning="Least speed at the goal.")
    turn_angle: float = option(
        0.785, gt=0.0, unit="rad", meaning="A differential drive turns on the spot for a point ahead beyond this angle."
    )

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        yield from renewal.renewal_problems(self)
        if self.lookahead_max is not None and self.lookahead_max < self.lookahead_min:
            yield "lookahead_max", f"must be >= lookahead_min, {self.lookahead_min:g}, got {self.lookahead_max:g}"

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> None:
        """Make room for the ways, and fill in what is not given."""
        speed = group.params["speed"]
        group.params["speed"] = np.where(np.isnan(speed), np.inf, speed)
        group.tables = PursuitTables.reserve(group, model, n_slots)

    @staticmethod
    def begin(group: Group, shard: Shard) -> None:
        """Forget the ways of worlds that begin."""
        forget_ways(shard.worlds, group.tables)

    @staticmethod
    def decide(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Write the members' commands; all members of a group have one drive."""
        worlds, slot = shard.worlds, shard.slot
        pursue_known(worlds, slot, group.members, group.params, group.tables, model, model.cells, state)


@kernel
def pursue_known(
    worlds: Ints,
    slot: int,
    members: Ints,
    params: Any,
    tables: PursuitTables,
    model: WorldModel,
    cells: CellMaps | None,
    state: WorldState,
) -> None:
    """Write the commands of bodies that know all that stands.

    Reads: tables (back, by_rate, coarse, count, everything, fine, goal, margin, points, retry, side, standing, whole),
        model (has_goal, heedless, movable, present, role, seen_row, stands, unobstructed, watchers), state (arrived,
        goal, stopped).
    Writes: tables (back, coarse, count, everything, fine, goal, margin, points, retry, side, standing, whole), state
        (command).
    """
    standing, everything = tables.standing[slot], tables.everything[slot]
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            clear_command(state, w, b)
            if not is_under_way(model, state, w, b):
                continue
            mark_standing(model, w, b, standing)
            mark_moving(model, w, b, params[k].target_roles, standing, everything)
            fixed, all_there = (
                Obstacles(model, state, w, standing, cells, None),
                Obstacles(model, state, w, everything, cells, None),
            )
            pursue(fixed, all_there, params[k], tables, slot, b)


@kernel
def is_under_way(model: WorldModel, state: WorldState, w: int, b: int) -> bool:
    """Return whether a body has somewhere to go and may go there.

    Reads: model (has_goal, present), state (arrived, goal, stopped).
    """
    if not model.has_goal[b] or not model.present[w, b] or state.stopped[w, b] or state.arrived[w, b]:
        return False
    return bool(state.goal[w, b, 0] == state.goal[w, b, 0])


@kernel
def turns_at_goal(model: WorldModel, state: WorldState, w: int, b: int) -> bool:
    """Return whether a body that is to arrive with a heading is near enough to its goal to turn there, if it can.

    Reads: model (arrive_mode, drive, goal_threshold), state (goal, pose).
    """
    dx, dy = state.goal[w, b, 0] - state.pose[w, b, 0], state.goal[w, b, 1] - state.pose[w, b, 1]
    near = 0.5 * model.goal_threshold[row_of(model.goal_threshold, w), b]
    if model.arrive_mode[b] != STATE or model.drive[b] not in (DIFFERENTIAL, OMNI_ANGULAR):
        return False
    return bool(dx * dx + dy * dy < near * near and state.goal[w, b, 2] == state.goal[w, b, 2])


@kernel
def mark_moving(model: WorldModel, w: int, own: int, target_roles: int, standing: Flags, everything: Flags) -> None:
    """Write what stands in the way of a body, and what moves.

    Reads: model (heedless, movable, present, role, seen_row, stands, unobstructed, watchers).
    Writes: everything.
    """
    for b in range(standing.shape[0]):
        moves = not model.stands[b] and not model.unobstructed[b] and is_seen(model, w, own, b, target_roles)
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
    goal, here = (state.goal[w, b, 0], state.goal[w, b, 1]), (state.pose[w, b, 0], state.pose[w, b, 1])
    reach, moving = model.reach[row_of(model.reach, w), b], moving_of(model, state, w, b, tables.by_rate[m])
    is_new = not (tables.goal[w, m, 0] == goal[0] and tables.goal[w, m, 1] == goal[1])
    is_new = is_new or (not tables.whole[w, m] and tables.side[w, m] >= MOST_POINTS - 2)
    if turns_at_goal(model, state, w, b):
        axis = 1 if moving.drive == DIFFERENTIAL else 2
        state.command[w, b, axis] = spin(moving, axis, wrap_below(state.goal[w, b, 2] - state.pose[w, b, 2]))
        return
    for _ in range(2):
        if is_new:
            find_way(standing, reach, options.clearance, (here, goal), tables, slot, m)
            tables.retry[w, m] = state.step[w] + PATIENCE
        if tables.count[w, m] > 0:
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
