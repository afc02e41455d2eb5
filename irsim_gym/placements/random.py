"""random: uniform in a box, clear of everything, with a goal that can be reached."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.arraytypes import CellMaps, Flags, Floats, Ints
from irsim_gym.geometry.buckets import bucket_of, gather_nearby, put
from irsim_gym.jit import kernel
from irsim_gym.paths.grid import Grid
from irsim_gym.placements.free_space import (
    WayGrids,
    has_way_of_length,
    is_goal_free,
    is_spaced,
    is_start_free,
    length_option,
    length_problems,
    way_grids,
)
from irsim_gym.placements.manual import world_box
from irsim_gym.rng import uniform
from irsim_gym.scenario.options import crossed_bounds, kind, option
from irsim_gym.structs import Struct
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.outline import place_outline
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

MARGIN = 0.5
WISHED_DISTANCE = 1.0
"""Distance [m] between members of an entry that asks for none, where they find room for it."""
FULLEST = 0.45
"""Share of a plane that discs put down at random cover without much searching; they never cover more than 0.547 of it
(Feder, Journal of Theoretical Biology 87, 1980).
"""
START_TRIES = 1000
GOAL_TRIES = 100
PATH_TRIES = 8
COARSE, FINE = 1.0, 0.5
"""Sides of cells, relative to the reach of the body that looks for a way."""


@dataclass(repr=False)
class DrawTables(Struct):
    """What the starts and goals of one entry are drawn from.

    Attributes:
        low: Lower bounds of the starts [m, m, rad], shape ``(3,)``.
        high: Upper bounds of the starts, likewise.
        goal_low: Lower bounds of the goals, likewise.
        goal_high: Upper bounds of the goals, likewise.
        min_distance: Least distance between the origins, and between the goals, of two members [m].
        clearance: Surface distance kept from everything else [m].
        min_goal_distance: Least distance from start to goal [m].
        needs_way: A start counts only where there is a free way to the goal.
        limits: Least and greatest length of that way [m], shape ``(2,)``.
        is_member: Bodies of the entry, shape ``(n_bodies,)``.
        everyone: Numbers of all bodies.
    """

    low: Floats
    high: Floats
    goal_low: Floats
    goal_high: Floats
    min_distance: float
    clearance: float
    min_goal_distance: float
    needs_way: bool
    limits: Floats
    is_member: Flags
    everyone: Ints


@kind
class RandomPlacement:
    """Uniform draws without any overlap; a draw that fails too often is an error that names the body."""

    only_kernels: ClassVar[bool] = True
    is_random: ClassVar[bool] = True
    roams: ClassVar[bool] = True
    gives_goal: ClassVar[bool] = True

    range_low: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Lower bounds; by default the world drawn in by 0.5 m, and -pi."
    )
    range_high: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Upper bounds; by default the world drawn in by 0.5 m, and pi."
    )
    goal_low: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Lower bounds of the goals; by default those of the starts."
    )
    goal_high: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Upper bounds of the goals; by default those of the starts."
    )
    min_distance: float | None = option(
        None,
        ge=0.0,
        unit="m",
        meaning="Least distance between the origins (and between the goals) of one entry; by default 1 m, or 0 "
        "where so many have no room for that.",
        consequence="As clearance.",
    )
    clearance: float = option(
        0.0,
        ge=0.0,
        unit="m",
        meaning="Surface distance kept from everything else.",
        consequence="Large in a full world: levels take long to draw, or cannot be.",
    )
    min_goal_distance: float = option(
        0.0,
        ge=0.0,
        unit="m",
        meaning="Least distance from start to goal.",
        consequence="Larger than the world: an error that names the body.",
    )
    reachable: bool = option(
        False, meaning="Hand out only goals that a disc around the body can reach past the static bodies."
    )
    min_way_length: float = length_option("min_way_length")
    max_way_length: float | None = length_option("max_way_length")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        yield from length_problems(self.min_way_length, self.max_way_length)
        if self.range_low is not None and self.range_high is not None:
            yield from crossed_bounds(self.range_low, self.range_high)
        if self.goal_low is not None and self.goal_high is not None:
            yield from crossed_bounds(self.goal_low, self.goal_high, "goal_low", "goal_high")

    @property
    def ensures_way(self) -> bool:
        """True if no level is drawn without a way from start to goal."""
        return self.reachable or self.min_way_length > 0.0 or self.max_way_length is not None

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> str | None:
        """Settle the bounds, and make room for the grid on which ways are looked for; return what does not fit."""
        options = group.options[0]
        low, high, goal_low, goal_high = bounds = _bounds(options, model)
        for name, lower, upper in (("range", low, high), ("goal", goal_low, goal_high)):
            if np.any(lower > upper):
                ends = [[round(float(value), 6) for value in bound] for bound in (lower, upper)]
                missing = f"the world less {MARGIN} m" if name == "range" else "that of the starts"
                return f"{name}_low {ends[0]} exceeds {name}_high {ends[1]}; what is not given is {missing}"
        corners = np.array([*(bound[:2] for bound in bounds), model.bounds[:2], model.bounds[2:]])
        area = (*corners.min(axis=0).tolist(), *corners.max(axis=0).tolist())
        min_distance = options.min_distance
        if min_distance is None:
            has_room = all(_has_room(len(group.members), *ends) for ends in ((low, high), (goal_low, goal_high)))
            min_distance = WISHED_DISTANCE if has_room else 0.0
        everyone = np.arange(len(model.role))
        spacing, clearance, away = float(min_distance), float(options.clearance), float(options.min_goal_distance)
        reach = float(np.max(model.bounds[2:] - model.bounds[:2]))
        if options.ensures_way:
            reach = float(np.min(model.reach[:, group.members]))
        limits = np.array([options.min_way_length, options.max_way_length or np.inf])
        grids = [Grid.over(area, share * reach) for share in (COARSE, FINE)]
        is_member = np.isin(everyone, group.members)
        numbers = spacing, clearance, away, options.ensures_way
        tables = DrawTables(*bounds, *numbers, limits, is_member, everyone)
        group.tables = tables, way_grids(grids, n_slots, len(everyone), limits.tolist())
        return None

    @staticmethod
    def draw(group: Group, model: WorldModel, state: WorldState, shard: Shard, failed: Ints) -> None:
        """Draw starts and goals; ``failed[w]`` becomes body + 1 where a member found no place."""
        tables, grids = group.tables
        grids = grids.of_slot(shard.slot)
        draw_members(shard.worlds, group.members, tables, grids, model, state, model.cells, failed)


def _has_room(count: int, low: Floats, high: Floats) -> bool:
    """Return whether so many points find places in a box that are ``WISHED_DISTANCE`` apart."""
    width, height = high[:2] - low[:2] + WISHED_DISTANCE
    return bool(count * np.pi * (WISHED_DISTANCE / 2.0) ** 2 <= FULLEST * width * height)


def _bounds(options: RandomPlacement, model: WorldModel) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the lower and upper bounds of the starts and of the goals."""
    low, high = world_box(model, MARGIN)
    low = low if options.range_low is None else np.array(options.range_low, np.float64)
    high = high if options.range_high is None else np.array(options.range_high, np.float64)
    goal_low = low if options.goal_low is None else np.array(options.goal_low, np.float64)
    goal_high = high if options.goal_high is None else np.array(options.goal_high, np.float64)
    return low, high, goal_low, goal_high


@kernel
def draw_members(
    worlds: Ints,
    members: Ints,
    tables: DrawTables,
    grids: WayGrids,
    model: WorldModel,
    state: WorldState,
    cells: CellMaps | None,
    failed: Ints,
) -> None:
    """Place one member after the other in each world, those that have no place yet, until one finds none.

    Reads: tables (clearance, goal_high, goal_low, high, is_member, limits, low, min_distance, min_goal_distance,
        needs_way), model (bucket_frame, bucketed, disc_count, disc_start, goal_renewal, has_goal, local_discs,
        local_segments, present, reach, segment_count, segment_start, solid, stands, waypoint_count, waypoints), state
        (bucket, bucket_first, bucket_next, discs, nearby, placed, pose, random, segments).
    Writes: grids, model (waypoints), state (bucket, bucket_first, bucket_next, discs, nearby, placed, pose, random,
        segments), failed.
    """
    placed, has_buckets = state.placed, model.bucket_frame[0].columns > 0
    for w in worlds:
        if has_buckets:
            sort_placed(w, model, state)
        for b in members:
            if failed[w] > 0 or not model.present[w, b] or placed[w, b]:
                continue
            for _ in range(PATH_TRIES if model.has_goal[b] else 1):
                placed[w, b] = draw_start(w, b, members, tables, model, state, cells) and (
                    not model.has_goal[b] or draw_goal(w, b, members, tables, model, state, cells)
                )
                if placed[w, b] and tables.needs_way and model.has_goal[b]:
                    placed[w, b] = has_way_of_length(w, b, tables.limits, grids, model, state, cells)
                if placed[w, b]:
                    break
            if not placed[w, b]:
                failed[w] = b + 1
            elif has_buckets:
                put_placed(w, b, model, state)


@kernel
def sort_placed(w: int, model: WorldModel, state: WorldState) -> None:
    """Let the buckets of world w hold the placed bodies and nobody else.

    Reads: model (bucket_frame, bucketed, present), state (bucket, bucket_first, bucket_next, placed, pose).
    Writes: state (bucket, bucket_first, bucket_next).
    """
    state.bucket[w, :], state.bucket_first[w, :], state.bucket_next[w, :] = -1, -1, -1
    for b in range(state.placed.shape[1]):
        if state.placed[w, b] and model.present[w, b]:
            put_placed(w, b, model, state)


@kernel
def put_placed(w: int, b: int, model: WorldModel, state: WorldState) -> None:
    """Put body b of world w into its bucket.

    Reads: model (bucket_frame, bucketed), state (bucket, bucket_first, bucket_next, pose).
    Writes: state (bucket, bucket_first, bucket_next).
    """
    place = bucket_of(state.pose[w, b, 0], state.pose[w, b, 1], model.bucketed[b], model.bucket_frame[0])
    put(b, place, state.bucket[w], state.bucket_first[w], state.bucket_next[w])


@kernel
def draw_start(
    w: int, b: int, members: Ints, tables: DrawTables, model: WorldModel, state: WorldState, cells: CellMaps | None
) -> bool:
    """Draw a pose for body b that is clear of everything placed so far; return whether there is one.

    Reads: tables (clearance, high, is_member, low, min_distance), model (bucket_frame, disc_count, disc_start,
        goal_renewal, has_goal, local_discs, local_segments, present, reach, segment_count, segment_start, solid,
        stands, waypoint_count, waypoints), state (bucket_first, bucket_next, discs, nearby, placed, pose, random,
        segments).
    Writes: state (discs, nearby, pose, random, segments).
    """
    frame, pose, placed, peers, others = model.bucket_frame[0], state.pose[w], state.placed[w], members, tables.everyone
    first, following, found = state.bucket_first[w], state.bucket_next[w], state.nearby[w]
    own = model.reach[row_of(model.reach, w), b]
    for _ in range(START_TRIES):
        for axis in range(3):
            pose[b, axis] = uniform(state.random, w, tables.low[axis], tables.high[axis])
        if frame.columns > 0:
            within = max(tables.min_distance, own + tables.clearance + frame.reach)
            count = gather_nearby(pose[b, 0], pose[b, 1], within, frame, first, following, found)
            peers, others = found[:count], found[:count]
        if not is_spaced(pose, b, peers, tables.is_member, tables.min_distance, model.present[w], placed):
            continue
        place_outline(model, state, w, b)
        if is_start_free(w, b, others, tables.clearance, model, state, cells):
            return True
    return False


@kernel
def draw_goal(
    w: int, b: int, members: Ints, tables: DrawTables, model: WorldModel, state: WorldState, cells: CellMaps | None
) -> bool:
    """Draw a goal for body b that its footprint can stand on; return whether there is one.

    Reads: tables (clearance, goal_high, goal_low, is_member, limits, min_distance, min_goal_distance), model
        (disc_count, disc_start, goal_renewal, has_goal, present, reach, segment_count, segment_start, solid, stands,
        waypoints), state (discs, placed, pose, random, segments).
    Writes: model (waypoints), state (random).
    """
    goals, goal, least = model.waypoints[w, :, 0], model.waypoints[w, b, 0], tables.min_goal_distance
    most = tables.limits[1]
    for _ in range(GOAL_TRIES):
        for axis in range(3):
            goal[axis] = uniform(state.random, w, tables.goal_low[axis], tables.goal_high[axis])
        dx, dy = goal[0] - state.pose[w, b, 0], goal[1] - state.pose[w, b, 1]
        if dx * dx + dy * dy < least * least or dx * dx + dy * dy > most * most:
            continue
        placed = state.placed[w]
        if not is_spaced(goals, b, members, tables.is_member, tables.min_distance, model.present[w], placed):
            continue
        if is_goal_free(w, b, tables.clearance, model, state, cells):
            return True
    return False
