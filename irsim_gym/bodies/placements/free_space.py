"""Tests of random draws: spacing, room for start and goal, and a path between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import BodyOutline, Bytes, Cells, Flags, Floats, Ints, Point
from irsim_gym.simulator.cell_maps.world_maps import map_is_closer, outline_near_map
from irsim_gym.simulator.geometry.overlap import outline_distance, outlines_overlap, point_outline_distance
from irsim_gym.simulator.paths.clearance import Obstacles
from irsim_gym.simulator.paths.geodesic import shortest_path
from irsim_gym.simulator.paths.grid import Grid, Search
from irsim_gym.simulator.paths.pulling import path_length
from irsim_gym.simulator.paths.regions import WayTables, of_slot, way_exists, way_tables
from irsim_gym.simulator.world.model import KEEP_GOAL, WANDER
from irsim_gym.simulator.world.names import Model, State, kernel, option, outline_of, row_of


class WayGrids(NamedTuple):
    """Two grids for searching a path.

    Attributes:
        blocks: Scratch, shape ``(n_bodies,)``; this and the tables have a first axis for the slot until ``of_slot``.
        coarse: The coarse grid; a path on it is a proof.
        fine: The fine grid, used if the coarse one has no path.
        search: Memory for measuring lengths of paths; None if they are not needed.
    """

    blocks: Flags
    coarse: WayTables
    fine: WayTables
    search: WaySearch | None

    def of_slot(self, slot: int) -> WayGrids:
        """Return one slot's share of the memory."""
        search = None if self.search is None else self.search.of_slot(slot)
        return WayGrids(self.blocks[slot], of_slot(self.coarse, slot), of_slot(self.fine, slot), search)


class WaySearch(NamedTuple):
    """Memory for searching the shortest path; arrays have a first axis for the slot until ``of_slot``.

    Attributes:
        grid: The grid.
        blocked: See ``simulator.paths.grid.Search``.
        field: See ``simulator.paths.grid.Search``.
        queue: See ``simulator.paths.grid.Search``.
        path: Points of a path [m], shape ``(n_points, 2)``.
    """

    grid: Grid
    blocked: Bytes
    field: Floats
    queue: Ints
    path: Floats

    def of_slot(self, slot: int) -> WaySearch:
        """Return one slot's share of the memory."""
        return WaySearch(self.grid, self.blocked[slot], self.field[slot], self.queue[slot], self.path[slot])


def way_grids(grids: Sequence[Grid], n_slots: int, n_bodies: int, limits: Sequence[float]) -> WayGrids:
    """Return memory for paths on a coarse and a fine grid, and for their lengths if these have ``limits`` [m]."""
    coarse, fine = (way_tables(grid, n_slots, n_bodies) for grid in grids)
    search = None
    if limits[0] > 0.0 or limits[1] < np.inf:
        shared, points = grids[1].search(), grids[1].path()
        arrays = (np.zeros((n_slots, *each.shape), each.dtype) for each in (*shared, points))
        search = WaySearch(grids[1], *arrays)
    return WayGrids(np.zeros((n_slots, n_bodies), np.bool_), coarse, fine, search)


def length_option(name: str) -> Any:
    """Declare the option ``min_way_length`` or ``max_way_length``."""
    if name == "min_way_length":
        return option(
            0.0,
            ge=0.0,
            unit="m",
            meaning="Minimum length of the shortest way from start to goal, past the map and static bodies.",
            consequence="Longer than any way: an error that names the body.",
        )
    return option(
        None,
        gt=0.0,
        unit="m",
        meaning="Maximum length of that way. It is measured over cells half as wide as the body's reach, which may "
        "add 3 %. Default: any.",
        consequence="Little more than the minimum: levels take long to draw, or cannot be drawn.",
    )


def length_problems(least: float, most: float | None) -> Iterator[tuple[str, str]]:
    """Yield a problem if no path can meet both bounds of its length."""
    if most is not None and most < least:
        yield "max_way_length", f"must not be less than min_way_length, got {most:g} and {least:g}"


@kernel
def is_spaced(
    points: Floats, b: int, others: Ints, is_member: Flags, spacing: float, present: Flags, placed: Flags
) -> bool:
    """Return whether point ``b`` keeps its distance from those members among ``others`` that are placed."""
    for q in others:
        dx, dy = points[q, 0] - points[b, 0], points[q, 1] - points[b, 1]
        if q != b and is_member[q] and present[q] and placed[q] and dx * dx + dy * dy < spacing * spacing:
            return False
    return True


@kernel
def is_start_free(w: int, b: int, others: Ints, clearance: float, model: Model, state: State, cells: Cells) -> bool:
    """Return whether body b, at its present outline, is clear of the map and of the placed bodies among ``others``.

    A body that never moves must be clear of all placed bodies' goals, too.

    Reads: model (disc_count, disc_start, drawn_goals, goal_renewal, has_goal, kept_clearance, present, reach,
        segment_count, segment_start, solid, stands, waypoint_count, waypoints), state (discs, placed, pose, segments).
    """
    outline, reaches = outline_of(model, state, w, b), model.reach[row_of(model.reach, w)]
    if outline_near_map(cells, w, outline, clearance):
        return False
    if model.stands[b] and not is_clear_of_goals(w, b, clearance, model, state):
        return False
    for q in others:
        if q == b or not state.placed[w, q] or not model.present[w, q]:
            continue
        dx, dy = state.pose[w, q, 0] - state.pose[w, b, 0], state.pose[w, q, 1] - state.pose[w, b, 1]
        room = max(clearance, model.kept_clearance[q])
        near = reaches[b] + reaches[q] + room
        # Reaches that do not meet cannot touch; the margin is for rounding.
        if dx * dx + dy * dy > near * near * (1.0 + 1e-12):
            continue
        if is_closer(room, outline, outline_of(model, state, w, q)):
            return False
    return True


@kernel
def is_clear_of_goals(w: int, b: int, clearance: float, model: Model, state: State) -> bool:
    """Return whether body b, at its present outline, is clear of the goals of all placed bodies.

    Reads: model (disc_count, disc_start, drawn_goals, goal_renewal, has_goal, kept_clearance, present, reach,
        segment_count, segment_start, solid, waypoint_count, waypoints), state (discs, placed, segments).
    """
    outline, reaches = outline_of(model, state, w, b), model.reach[row_of(model.reach, w)]
    for q in range(reaches.shape[0]):
        # Wandering bodies draw their goals during the episode.
        if not model.has_goal[q] or model.goal_renewal[q] == WANDER or q == b:
            continue
        if not state.placed[w, q] or not model.present[w, q]:
            continue
        for k in range(kept_goals(w, q, model)):
            x, y = model.waypoints[w, q, k, 0], model.waypoints[w, q, k, 1]
            if point_outline_distance((x, y), outline) < reaches[q] + max(clearance, model.kept_clearance[q]):
                return False
    return True


@kernel
def kept_goals(w: int, b: int, model: Model) -> int:
    """Return the number of goals of body b from which others keep clear.

    These are all of its goals; of a loop, those that are drawn, or only the first.

    Reads: model (drawn_goals, goal_renewal, waypoint_count).
    """
    return int(model.waypoint_count[w, b] if model.goal_renewal[b] == KEEP_GOAL else max(model.drawn_goals[b], 1))


@kernel
def is_closer(clearance: float, outline: BodyOutline, other: BodyOutline) -> bool:
    """Return whether two outlines touch, or come closer than ``clearance`` [m]."""
    if clearance <= 0.0:
        return outlines_overlap(outline, other)
    return bool(outline_distance(outline, other, clearance) < clearance)


@kernel
def is_goal_free(w: int, b: int, k: int, clearance: float, model: Model, state: State, cells: Cells) -> bool:
    """Return whether a disc around body b at its goal k is clear of the map, placed static bodies and others' goals.

    Reads: model (disc_count, disc_start, drawn_goals, goal_renewal, has_goal, kept_clearance, present, reach,
        segment_count, segment_start, solid, stands, waypoint_count, waypoints), state (discs, placed, pose, segments).
    """
    reaches, waypoints = model.reach[row_of(model.reach, w)], model.waypoints[w]
    x, y = waypoints[b, k, 0], waypoints[b, k, 1]
    if map_is_closer(cells, w, (x, y), reaches[b] + clearance):
        return False
    for q in range(reaches.shape[0]):
        if q == b or not state.placed[w, q] or not model.present[w, q]:
            continue
        if model.has_goal[q] and model.goal_renewal[q] != WANDER:
            # Between goals, bodies only must not overlap; `clearance` is kept from what stands.
            apart = reaches[b] + reaches[q]
            for i in range(kept_goals(w, q, model)):
                dx, dy = waypoints[q, i, 0] - x, waypoints[q, i, 1] - y
                if dx * dx + dy * dy < apart * apart:
                    return False
        if not model.stands[q]:
            continue
        dx, dy = state.pose[w, q, 0] - x, state.pose[w, q, 1] - y
        room = max(clearance, model.kept_clearance[q])
        near = reaches[b] + reaches[q] + room
        if dx * dx + dy * dy > near * near:
            continue
        if point_outline_distance((x, y), outline_of(model, state, w, q)) < reaches[b] + room:
            return False
    return True


@kernel
def leg_start(w: int, b: int, k: int, model: Model, state: State) -> Point:
    """Return the point [m] from which body b goes to its goal k: the goal before it, or the start.

    Reads: model (waypoints), state (pose).
    """
    if k == 0:
        return (state.pose[w, b, 0], state.pose[w, b, 1])
    return (model.waypoints[w, b, k - 1, 0], model.waypoints[w, b, k - 1, 1])


@kernel
def has_way_of_length(
    w: int, b: int, k: int, limits: Floats, grids: WayGrids, model: Model, state: State, cells: Cells
) -> bool:
    """Return whether a disc around body b has a free way to its goal k, whose length is within ``limits`` [m].

    Reads: model (present, reach, stands, waypoints), state (placed, pose).
    Writes: grids.
    """
    start, goal = leg_start(w, b, k, model, state), (model.waypoints[w, b, k, 0], model.waypoints[w, b, k, 1])
    dx, dy = goal[0] - start[0], goal[1] - start[1]
    straight = np.sqrt(dx * dx + dy * dy)
    if straight > limits[1] or not has_way(w, b, start, goal, grids, model, state, cells):
        return False
    # No way is shorter than the straight line, so its length need not be measured.
    if straight >= limits[0] and limits[1] == np.inf:
        return True
    obstacles, radius = Obstacles(model, state, w, grids.blocks, cells, None), model.reach[row_of(model.reach, w), b]
    return bool(limits[0] <= way_length(grids.search, obstacles, radius, start, goal) <= limits[1])


@kernel
def confirm_ways(
    worlds: Ints, bodies: Ints, limits: Floats, grids: WayGrids, model: Model, state: State, cells: Cells, failed: Ints
) -> None:
    """Set ``failed`` to body + 1 where a body has no way through its goals within ``limits`` [m] any more.

    Bodies that were placed after it may stand in its way.

    Reads: model (drawn_goals, present, reach, stands, waypoints), state (placed, pose).
    Writes: grids, failed.
    """
    for w in worlds:
        for b in bodies:
            for k in range(model.drawn_goals[b] if model.present[w, b] else 0):
                if failed[w] == 0 and not has_way_of_length(w, b, k, limits, grids, model, state, cells):
                    failed[w] = b + 1


@kernel
def way_length(search: WaySearch | None, obstacles: Obstacles, radius: float, start: Point, goal: Point) -> float:
    """Return the length of the shortest path found [m]: inf without a path, 0 if lengths are not measured.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: search.
    """
    if search is None:
        return 0.0
    memory = Search(search.blocked, search.field, search.queue)
    count = shortest_path(obstacles, radius, start, goal, search.grid, memory, search.path)
    return float(path_length(search.path, count)) if count > 0 else np.inf


@kernel
def has_way(
    w: int, b: int, start: Point, goal: Point, grids: WayGrids, model: Model, state: State, cells: Cells
) -> bool:
    """Return whether a disc around body b has a free way between two points [m] past the placed static bodies.

    Reads: model (present, reach, stands), state (placed).
    Writes: grids.
    """
    blocks = grids.blocks
    for q in range(blocks.shape[0]):
        blocks[q] = q != b and state.placed[w, q] and model.present[w, q] and model.stands[q]
    obstacles = Obstacles(model, state, w, blocks, cells, None)
    radius = model.reach[row_of(model.reach, w), b]
    # A way on either grid is a proof; the coarse one takes less time.
    return way_exists(obstacles, radius, start, goal, grids.coarse) or way_exists(
        obstacles, radius, start, goal, grids.fine
    )
