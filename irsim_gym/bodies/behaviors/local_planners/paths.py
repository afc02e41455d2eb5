"""Computes the paths that local planners follow: on the map, or around what scans have shown."""

from typing import Any

import numpy as np

from irsim_gym.bodies.behaviors.local_planners.seen_way import find_seen_way, is_still_free, note_hit
from irsim_gym.bodies.behaviors.local_planners.task import LocalTables
from irsim_gym.bodies.behaviors.local_planners.way import ASTRAY, CELL, LocalWays, advance_on_way
from irsim_gym.simulator.paths.clearance import Obstacles, mark_standing
from irsim_gym.simulator.paths.geodesic import shortest_path
from irsim_gym.simulator.paths.grid import Search
from irsim_gym.simulator.world.names import Cells, Ints, Model, OwnScan, Point, State, find_hits, kernel, row_of

STRAIGHT, MAP, SEEN = 0, 1, 2
"""Kinds of paths, in the order of the option ``path``."""
PATIENCE = 0.5
"""Minimum time between two computations of a path around seen obstacles [s]."""
SHARES = (1.0, 0.5, 0.0)
"""Shares of a path's distance from obstacles that are tried in order until there is a path."""


@kernel
def find_paths(
    worlds: Ints, members: Ints, params: Any, scan: OwnScan, model: Model, cells: Cells, state: State,
    tables: LocalTables,
) -> None:  # fmt: skip
    """Note what the scans show, and compute the paths of members whose goal is new or that cannot follow theirs.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors), model (has_goal, present, reach,
        stands, step_time, unobstructed), state (goal, pose, step), tables (hits, ways).
    Writes: tables (hits, ways).
    """
    hits, ways = tables.hits, tables.ways
    search, grid = Search(ways.blocked, ways.field, ways.queue), ways.grid
    for w in worlds:
        for k in range(members.shape[0]):
            b, m, options, count = members[k], ways.row[members[k]], params[k], 0
            if options.path == STRAIGHT or not model.has_goal[b] or not model.present[w, b]:
                continue
            here, end = (state.pose[w, b, 0], state.pose[w, b, 1]), (state.goal[w, b, 0], state.goal[w, b, 1])
            # Steps count from 1, as 0 means in the tables that a cell was never found blocked.
            hard, soft, now = ways.seen.hard[w, m], ways.seen.soft[w, m], state.step[w] + 1
            reach, oldest = model.reach[row_of(model.reach, w), b], now - int(options.memory / model.step_time[0])
            if options.path == SEEN:
                cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
                for j in range(find_hits(scan, w, k, options.obstacle_range, hits)):
                    x = here[0] + cosine * hits[0, j] - sine * hits[1, j]
                    y = here[1] + sine * hits[0, j] + cosine * hits[1, j]
                    note_hit(x, y, reach, options.path_clearance, grid, now, hard, soft)
            # The goal NaN of a member without a path equals no goal.
            is_known = ways.goal[w, m, 0] == end[0] and ways.goal[w, m, 1] == end[1]
            if is_known and advance_on_way(ways, w, m, here) <= ASTRAY:
                # A blocked path, or none, is computed again, but not before the time in `since`.
                if options.path == MAP or now < ways.since[w, m]:
                    continue
                points, side, n_points = ways.points[w, m], ways.side[w, m], ways.count[w, m]
                if n_points > 1 and is_still_free(points, side, n_points, grid, soft, max(oldest, 0)):
                    continue
            if options.path == SEEN:
                ways.since[w, m] = now + int(PATIENCE / model.step_time[0])
                count = find_seen_way(here, end, grid, soft, max(oldest, 0), search, ways.path)
                # No path keeps the wished distance: any path on which the body itself fits will do.
                if count == 0:
                    count = find_seen_way(here, end, grid, hard, max(oldest, 0), search, ways.path)
            else:
                mark_standing(model, w, b, ways.blocks)
                obstacles = Obstacles(model, state, w, ways.blocks, cells, None)
                for share in SHARES:
                    if count == 0:
                        radius = reach + share * options.path_clearance
                        count = shortest_path(obstacles, radius, here, end, grid, search, ways.path)
            keep_way(ways, w, m, count, end)


@kernel
def keep_way(ways: LocalWays, w: int, m: int, count: int, goal: Point) -> None:
    """Store the points of a path, without those that are closer than ``CELL`` to the one before.

    Reads: ways (path, points).
    Writes: ways (count, goal, points, side).
    """
    points, n_points, most = ways.points[w, m], 0, ways.points.shape[2]
    for i in range(count):
        x, y = ways.path[i, 0], ways.path[i, 1]
        # The first and the last point are always kept.
        if n_points > 0 and i < count - 1:
            dx, dy = x - points[n_points - 1, 0], y - points[n_points - 1, 1]
            if n_points == most or dx * dx + dy * dy < CELL * CELL:
                continue
        # If the memory is full, the last point replaces the one before it.
        n_points = min(n_points + 1, most)
        points[n_points - 1, 0], points[n_points - 1, 1] = x, y
    ways.goal[w, m, 0], ways.goal[w, m, 1], ways.side[w, m], ways.count[w, m] = goal[0], goal[1], 0, n_points
