"""Draws starts and goals uniformly from boxes, one body after another."""

from dataclasses import dataclass

from irsim_gym.bodies.placements import free_space
from irsim_gym.bodies.placements.free_space import WayGrids
from irsim_gym.simulator.geometry.buckets import bucket_of, gather_nearby, put
from irsim_gym.simulator.world.names import Cells, Flags, Floats, Ints, Model, State, Struct, kernel, row_of, uniform
from irsim_gym.simulator.world.outline import place_outline

START_TRIES = 1000
"""Maximum number of draws for a start."""
GOAL_TRIES = 100
"""Maximum number of draws for a goal."""
PATH_TRIES = 8
"""Maximum number of draws of a start with a goal, or of a next goal, until a path leads there."""


@dataclass(repr=False)
class DrawTables(Struct):
    """The tables for drawing the starts and goals of one entry.

    Attributes:
        low: Lower bounds of the starts [m, m, rad], shape ``(3,)``.
        high: Upper bounds of the starts, likewise.
        goal_low: Lower bounds of the goals, likewise.
        goal_high: Upper bounds of the goals, likewise.
        min_distance: Minimum distance between the origins, and between the goals, of two members [m].
        clearance: Minimum surface distance from everything else [m].
        min_goal_distance: Minimum distance from start to goal, and from goal to goal [m].
        needs_way: Whether there must be a free path from the start to the goal, and from each goal to the next.
        limits: Minimum and maximum length of that path [m], shape ``(2,)``.
        is_member: Flags of the entry's bodies, shape ``(n_bodies,)``.
        members: Numbers of the entry's bodies.
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
    members: Ints
    everyone: Ints


@kernel
def draw_members(
    worlds: Ints, tables: DrawTables, grids: WayGrids, model: Model, state: State, cells: Cells, failed: Ints
) -> None:
    """Place the members of each world that are not placed yet one after another, until one finds no place.

    Reads: tables (clearance, goal_high, goal_low, high, is_member, limits, low, members, min_distance,
        min_goal_distance, needs_way), model (bucket_frame, bucketed, disc_count, disc_start, drawn_goals, goal_renewal,
        has_goal, kept_clearance, local_discs, local_segments, present, reach, segment_count, segment_start, solid,
        stands, waypoint_count, waypoints), state (bucket, bucket_first, bucket_next, discs, nearby, placed, pose,
        random, segments).
    Writes: grids, model (waypoints), state (bucket, bucket_first, bucket_next, discs, nearby, placed, pose, random,
        segments), failed.
    """
    placed, has_buckets = state.placed, model.bucket_frame[0].columns > 0
    for w in worlds:
        if has_buckets:
            sort_placed(w, model, state)
        for b in tables.members:
            if failed[w] > 0 or not model.present[w, b] or placed[w, b]:
                continue
            for _ in range(PATH_TRIES if model.has_goal[b] else 1):
                placed[w, b] = draw_start(w, b, tables, model, state, cells) and (
                    not model.has_goal[b] or draw_goal(w, b, 0, tables, model, state, cells)
                )
                if placed[w, b] and tables.needs_way and model.has_goal[b]:
                    placed[w, b] = free_space.has_way_of_length(w, b, 0, tables.limits, grids, model, state, cells)
                if placed[w, b]:
                    break
            for k in range(1, model.drawn_goals[b]):
                placed[w, b] = placed[w, b] and draw_next_goal(w, b, k, tables, grids, model, state, cells)
            if not placed[w, b]:
                failed[w] = b + 1
            elif has_buckets:
                put_placed(w, b, model, state)


@kernel
def sort_placed(w: int, model: Model, state: State) -> None:
    """Fill the buckets of world w with the placed bodies only.

    Reads: model (bucket_frame, bucketed, present), state (bucket, bucket_first, bucket_next, placed, pose).
    Writes: state (bucket, bucket_first, bucket_next).
    """
    # Only for the draws: at the restart's end the engine sorts all bodies into the buckets anew.
    state.bucket[w, :], state.bucket_first[w, :], state.bucket_next[w, :] = -1, -1, -1
    for b in range(state.placed.shape[1]):
        if state.placed[w, b] and model.present[w, b]:
            put_placed(w, b, model, state)


@kernel
def put_placed(w: int, b: int, model: Model, state: State) -> None:
    """Put body b of world w into its bucket.

    Reads: model (bucket_frame, bucketed), state (bucket, bucket_first, bucket_next, pose).
    Writes: state (bucket, bucket_first, bucket_next).
    """
    place = bucket_of(state.pose[w, b, 0], state.pose[w, b, 1], model.bucketed[b], model.bucket_frame[0])
    put(b, place, state.bucket[w], state.bucket_first[w], state.bucket_next[w])


@kernel
def draw_start(w: int, b: int, tables: DrawTables, model: Model, state: State, cells: Cells) -> bool:
    """Draw a pose for body b that is clear of everything placed so far; return whether one was found.

    Reads: tables (clearance, high, is_member, low, min_distance), model (bucket_frame, disc_count, disc_start,
        drawn_goals, goal_renewal, has_goal, kept_clearance, local_discs, local_segments, present, reach, segment_count,
        segment_start, solid, stands, waypoint_count, waypoints), state (bucket_first, bucket_next, discs, nearby,
        placed, pose, random, segments).
    Writes: state (discs, nearby, pose, random, segments).
    """
    frame, pose, placed = model.bucket_frame[0], state.pose[w], state.placed[w]
    peers, others = tables.members, tables.everyone
    first, following, nearby = state.bucket_first[w], state.bucket_next[w], state.nearby[w]
    reach, clearance = model.reach[row_of(model.reach, w), b], tables.clearance
    for q in range(model.kept_clearance.shape[0]):
        clearance = max(clearance, model.kept_clearance[q])
    for _ in range(START_TRIES):
        for axis in range(3):
            pose[b, axis] = uniform(state.random, w, tables.low[axis], tables.high[axis])
        if frame.columns > 0:
            # What can be too near by origins, or by outlines, which reach out `frame.reach` at most.
            within = max(tables.min_distance, reach + clearance + frame.reach)
            count = gather_nearby(pose[b, 0], pose[b, 1], within, frame, first, following, nearby)
            peers, others = nearby[:count], nearby[:count]
        if not free_space.is_spaced(pose, b, peers, tables.is_member, tables.min_distance, model.present[w], placed):
            continue
        place_outline(model, state, w, b)
        if free_space.is_start_free(w, b, others, tables.clearance, model, state, cells):
            return True
    return False


@kernel
def draw_next_goal(
    w: int, b: int, k: int, tables: DrawTables, grids: WayGrids, model: Model, state: State, cells: Cells
) -> bool:
    """Draw goal k of body b, with a path from the goal before it if required; return whether one was found.

    Reads: tables (clearance, goal_high, goal_low, limits, members, min_distance, min_goal_distance, needs_way), model
        (disc_count, disc_start, drawn_goals, goal_renewal, has_goal, kept_clearance, present, reach, segment_count,
        segment_start, solid, stands, waypoint_count, waypoints), state (discs, placed, pose, random, segments).
    Writes: grids, model (waypoints), state (random).
    """
    for _ in range(PATH_TRIES):
        if not draw_goal(w, b, k, tables, model, state, cells):
            return False
        if not tables.needs_way or free_space.has_way_of_length(w, b, k, tables.limits, grids, model, state, cells):
            return True
    return False


@kernel
def draw_goal(w: int, b: int, k: int, tables: DrawTables, model: Model, state: State, cells: Cells) -> bool:
    """Draw goal k of body b, with room for its footprint; return whether one was found.

    Reads: tables (clearance, goal_high, goal_low, limits, members, min_distance, min_goal_distance), model (disc_count,
        disc_start, drawn_goals, goal_renewal, has_goal, kept_clearance, present, reach, segment_count, segment_start,
        solid, stands, waypoint_count, waypoints), state (discs, placed, pose, random, segments).
    Writes: model (waypoints), state (random).
    """
    goal, least, most = model.waypoints[w, b, k], tables.min_goal_distance, tables.limits[1]
    x, y = free_space.leg_start(w, b, k, model, state)
    for _ in range(GOAL_TRIES):
        for axis in range(3):
            goal[axis] = uniform(state.random, w, tables.goal_low[axis], tables.goal_high[axis])
        dx, dy = goal[0] - x, goal[1] - y
        if dx * dx + dy * dy < least * least or dx * dx + dy * dy > most * most:
            continue
        if not is_goal_spaced(w, b, k, tables, model, state):
            continue
        if free_space.is_goal_free(w, b, k, tables.clearance, model, state, cells):
            return True
    return False


@kernel
def is_goal_spaced(w: int, b: int, k: int, tables: DrawTables, model: Model, state: State) -> bool:
    """Return whether goal k of body b keeps its distance from all goals of the other placed members.

    Reads: tables (members, min_distance), model (drawn_goals, goal_renewal, present, waypoint_count, waypoints), state
        (placed).
    """
    goals, least = model.waypoints[w], tables.min_distance
    x, y = goals[b, k, 0], goals[b, k, 1]
    for q in tables.members:
        if q == b or not model.present[w, q] or not state.placed[w, q]:
            continue
        for i in range(free_space.kept_goals(w, q, model)):
            dx, dy = goals[q, i, 0] - x, goals[q, i, 1] - y
            if dx * dx + dy * dy < least * least:
                return False
    return True
