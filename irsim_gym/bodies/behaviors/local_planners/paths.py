"""Computes the paths that local planners follow: on the map, or around what scans have shown."""

from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import CellMaps, Floats, Ints, Point
from irsim_gym.bodies.behaviors.local_planners.seen_way import find_seen_way, is_still_free, note_hit
from irsim_gym.bodies.behaviors.local_planners.task import LocalTables
from irsim_gym.bodies.behaviors.local_planners.way import ASTRAY, CELL, LocalWays, advance_on_way
from irsim_gym.simulator.paths.clearance import Obstacles, mark_standing
from irsim_gym.simulator.paths.geodesic import shortest_path
from irsim_gym.simulator.paths.grid import Search
from irsim_gym.simulator.world.names import Group, Model, Shard, State, kernel, row_of
from irsim_gym.simulator.world.own_scan import OwnScan, find_hits

MAP, SEEN = 1, 2
"""Kinds of paths, in the order of the option ``path``."""
PATIENCE = 0.5
"""Minimum time between two computations of a path around seen obstacles [s]."""
SHARES = (1.0, 0.5, 0.0)
"""Shares of a path's distance from obstacles that are tried in order until there is a path."""


def find_paths(group: Group, model: Model, state: State, shard: Shard, tables: LocalTables) -> None:
    """Compute the paths of members that need one: the goal is new, or the path can no longer be followed."""
    paths = {options.path for options in group.options}
    if "seen" in paths:
        note_scans(shard.worlds, group.members, group.params, group.scan, model, state, tables.hits, tables.ways)
    if "map" in paths:
        find_ways(shard.worlds, group.members, group.params, model, model.cells, state, tables.ways)


@kernel
def note_scans(
    worlds: Ints, members: Ints, params: Any, scan: OwnScan, model: Model, state: State, hits: Floats, ways: LocalWays
) -> None:
    """Write what the scans show, and new paths for members that follow path ``seen`` and whose path is blocked.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors), model (has_goal, present, reach,
        step_time), state (goal, pose, step), ways (blocked, count, field, goal, grid, path, points, queue, row, seen,
        side, since).
    Writes: hits, ways (count, goal, path, points, seen, side, since).
    """
    search, grid = Search(ways.blocked, ways.field, ways.queue), ways.grid
    for w in worlds:
        for k in range(members.shape[0]):
            b, m, options = members[k], ways.row[members[k]], params[k]
            if options.path != SEEN or not model.has_goal[b] or not model.present[w, b]:
                continue
            here, end = (state.pose[w, b, 0], state.pose[w, b, 1]), (state.goal[w, b, 0], state.goal[w, b, 1])
            # Steps count from 1, as 0 means in the tables that a cell was never found blocked.
            hard, soft, now = ways.seen.hard[w, m], ways.seen.soft[w, m], state.step[w] + 1
            reach, oldest = model.reach[row_of(model.reach, w), b], now - int(options.memory / model.step_time[0])
            cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
            for j in range(find_hits(scan, w, k, options.obstacle_range, hits)):
                x = here[0] + cosine * hits[0, j] - sine * hits[1, j]
                y = here[1] + sine * hits[0, j] + cosine * hits[1, j]
                note_hit(x, y, reach, options.path_clearance, grid, now, hard, soft)
            # The goal NaN of a member without a path equals no goal.
            is_known = ways.goal[w, m, 0] == end[0] and ways.goal[w, m, 1] == end[1]
            if is_known and advance_on_way(ways, w, m, here) <= ASTRAY:
                free = is_still_free(ways.points[w, m], ways.side[w, m], ways.count[w, m], grid, soft, max(oldest, 0))
                # A blocked path, or none, is computed again, but not before the time in `since`.
                if (ways.count[w, m] > 1 and free) or now < ways.since[w, m]:
                    continue
            count = find_seen_way(here, end, grid, soft, max(oldest, 0), search, ways.path)
            # No path keeps the wished distance: any path on which the body itself fits will do.
            if count == 0:
                count = find_seen_way(here, end, grid, hard, max(oldest, 0), search, ways.path)
            ways.since[w, m] = now + int(PATIENCE / model.step_time[0])
            keep_way(ways, w, m, count, end)


@kernel
def keep_way(ways: LocalWays, w: int, m: int, count: int, goal: Point) -> None:
    """Store the points of a path, without those that are closer than ``CELL`` to the one before.

    Reads: ways (path, points).
    Writes: ways (count, goal, points, side).
    """
    points, kept, most = ways.points[w, m], 0, ways.points.shape[2]
    for i in range(count):
        x, y = ways.path[i, 0], ways.path[i, 1]
        # The first and the last point are always kept.
        if kept > 0 and i < count - 1:
            dx, dy = x - points[kept - 1, 0], y - points[kept - 1, 1]
            if kept == most or dx * dx + dy * dy < CELL * CELL:
                continue
        # If the memory is full, the last point replaces the one before it.
        kept = min(kept + 1, most)
        points[kept - 1, 0], points[kept - 1, 1] = x, y
    ways.goal[w, m, 0], ways.goal[w, m, 1], ways.side[w, m], ways.count[w, m] = goal[0], goal[1], 0, kept


@kernel
def find_ways(
    worlds: Ints, members: Ints, params: Any, model: Model, cells: CellMaps | None, state: State, ways: LocalWays
) -> None:
    """Find the paths of members that follow the map, where the goal is new or the body has gone astray.

    Reads: model (has_goal, present, reach, stands, unobstructed), state (goal, pose), ways (blocked, blocks, count,
        field, goal, grid, path, points, queue, row, side).
    Writes: ways (blocks, count, goal, path, points, side).
    """
    search = Search(ways.blocked, ways.field, ways.queue)
    for w in worlds:
        for k in range(members.shape[0]):
            b, m = members[k], ways.row[members[k]]
            if params[k].path != MAP or not model.has_goal[b] or not model.present[w, b]:
                continue
            here, end = (state.pose[w, b, 0], state.pose[w, b, 1]), (state.goal[w, b, 0], state.goal[w, b, 1])
            # The goal NaN of a member without a path equals no goal.
            is_known = ways.goal[w, m, 0] == end[0] and ways.goal[w, m, 1] == end[1]
            if is_known and advance_on_way(ways, w, m, here) <= ASTRAY:
                continue
            mark_standing(model, w, b, ways.blocks)
            reach = model.reach[row_of(model.reach, w), b]
            obstacles = Obstacles(model, state, w, ways.blocks, cells, None)
            count = 0
            for share in SHARES:
                if count == 0:
                    radius = reach + share * params[k].path_clearance
                    count = shortest_path(obstacles, radius, here, end, ways.grid, search, ways.path)
            keep_way(ways, w, m, count, end)
