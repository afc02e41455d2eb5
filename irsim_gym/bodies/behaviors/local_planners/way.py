"""The path of a local planner: straight to the goal, or the shortest path around everything that never moves."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Flags, Floats, Ints, Point, Vector
from irsim_gym.bodies.behaviors.local_planners.seen_way import SeenCells
from irsim_gym.bodies.behaviors.shared.steering import goal_offset
from irsim_gym.simulator.geometry.segments import point_segment_distance2
from irsim_gym.simulator.paths.grid import Grid
from irsim_gym.simulator.world.names import Group, Model, State, Struct, kernel

MOST_POINTS = 256
"""Maximum number of stored points of a path, CELL apart or more; beyond the last but one, the path is straight."""
CELL = 0.1
"""Cell size of the path search [m]."""
FINEST = 200
"""Maximum number of cells along the longer side of the world."""
ASTRAY = 1.0
"""Distance from its path above which a body gets a new one [m]."""


@dataclass(repr=False)
class LocalWays(Struct):
    """The paths of a group's members on the map, and scratch memory of one shard for computing them.

    Attributes:
        row: Number of each body among the members, shape ``(n_bodies,)``.
        goal: The goal of each path [m], NaN without one, shape ``(n_worlds, n_members, 2)``.
        points: Its points [m], shape ``(n_worlds, n_members, MOST_POINTS, 2)``.
        count: Number of its points, 0 for the straight line, shape ``(n_worlds, n_members)``.
        side: Segment of the path beside which the body was, shape ``(n_worlds, n_members)``.
        since: First step at which it may be computed again, shape ``(n_worlds, n_members)``.
        seen: What the members' scans have shown.
        grid: The grid.
        blocked: Scratch: see ``Search``.
        field: Scratch: see ``Search``.
        queue: Scratch: see ``Search``.
        path: Scratch: a computed path, shape ``(n, 2)``.
        blocks: Scratch: flags of bodies that are obstacles, shape ``(n_bodies,)``.
    """

    row: Ints
    goal: Floats
    points: Floats
    count: Ints
    side: Ints
    since: Ints
    seen: SeenCells
    grid: Grid
    blocked: Bytes
    field: Floats
    queue: Ints
    path: Floats
    blocks: Flags

    @classmethod
    def reserve(cls, group: Group, model: Model, n_slots: int) -> list[Self]:
        """Return memory for each slot; the paths themselves are shared, and empty where nobody follows the map."""
        n_worlds, n_members, n_bodies = len(model.present), len(group.members), len(model.role)
        row = np.zeros(n_bodies, np.int64)
        row[group.members] = np.arange(n_members)
        shape, kinds = (n_worlds, n_members), {options.path for options in group.options}
        n_points = 1 if kinds == {"straight"} else MOST_POINTS
        goal, points = np.full((*shape, 2), np.nan), np.zeros((*shape, n_points, 2))
        count, side, since = (np.zeros(shape, np.int64) for _ in range(3))
        side_length = max(float(model.bounds[2] - model.bounds[0]), float(model.bounds[3] - model.bounds[1]))
        # A single cell, where nobody needs the grid.
        unused = Grid(0.0, 0.0, 1.0, 1, 1)
        grid = unused if kinds == {"straight"} else Grid.over(model.bounds, max(CELL, side_length / FINEST))
        seen = SeenCells.reserve(*shape, grid if "seen" in kinds else unused)
        ways = []
        for _ in range(n_slots):
            search, blocks = grid.search(), np.zeros(n_bodies, np.bool_)
            ways.append(cls(row, goal, points, count, side, since, seen, grid, *search, grid.path(), blocks))
        return ways


@kernel
def forget_ways(worlds: Ints, ways: LocalWays) -> None:
    """Forget all paths of some worlds, and what was seen.

    Writes: ways (count, goal, seen, side, since).
    """
    for w in worlds:
        ways.goal[w, :, :] = np.nan
        ways.count[w, :], ways.side[w, :], ways.since[w, :] = 0, 0, 0
        ways.seen.hard[w, :, :, :], ways.seen.soft[w, :, :, :] = 0, 0


@kernel
def advance_on_way(ways: LocalWays, w: int, m: int, place: Point) -> float:
    """Update which side of its path a member is nearest to, and return its distance from the path [m].

    Reads: ways (count, points, side).
    Writes: ways (side).
    """
    best2, side, points, gone = np.inf, ways.side[w, m], ways.points[w, m], 0.0
    # From the known side onwards, a stretch of 2 ASTRAY: the path may come near again behind a wall.
    for i in range(ways.side[w, m], ways.count[w, m] - 1):
        ax, ay, bx, by = points[i, 0], points[i, 1], points[i + 1, 0], points[i + 1, 1]
        distance2 = point_segment_distance2(place[0], place[1], ax, ay, bx, by)
        if distance2 < best2:
            best2, side = distance2, i
        gone += np.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay))
        if gone > 2.0 * ASTRAY:
            break
    ways.side[w, m] = side
    return float(np.sqrt(best2)) if ways.count[w, m] > 1 else 0.0


@kernel
def lay_way(state: State, ways: LocalWays, w: int, b: int, length: float, way: Floats) -> int:
    """Write the path of a body from where it is nearest, in the frame of the body, and return its number of points.

    Reads: state (goal, pose), ways (count, points, row, side).
    Writes: way.

    Args:
        state: Current state of the worlds.
        ways: The paths.
        w: World.
        b: The body.
        length: Points farther ahead on the path are left out [m].
        way: Written: x and y [m], shape ``(2, MOST_POINTS + 1)``.
    """
    m, x, y = ways.row[b], state.pose[w, b, 0], state.pose[w, b, 1]
    cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
    points, count, side = ways.points[w, m], ways.count[w, m], ways.side[w, m]
    n_points = 1
    # The straight line begins at the body.
    way[0, 0], way[1, 0] = 0.0, 0.0
    if count > 1:
        # A stored path begins at its point nearest to the body: from there on, off_way measures progress.
        dx, dy = nearest_on_side(points, side, (x, y))
        way[0, 0], way[1, 0] = cosine * dx + sine * dy, cosine * dy - sine * dx
        driven = 0.0
        # Without the last point, which is the goal; that is appended below.
        for i in range(side + 1, count - 1):
            dx, dy = points[i, 0] - x, points[i, 1] - y
            way[0, n_points], way[1, n_points] = cosine * dx + sine * dy, cosine * dy - sine * dx
            dx, dy = way[0, n_points] - way[0, n_points - 1], way[1, n_points] - way[1, n_points - 1]
            n_points, driven = n_points + 1, driven + np.sqrt(dx * dx + dy * dy)
            if driven > length:
                return n_points
    dx, dy = goal_offset(state, w, b)
    way[0, n_points], way[1, n_points] = cosine * dx + sine * dy, cosine * dy - sine * dx
    return n_points + 1


@kernel
def nearest_on_side(points: Floats, side: int, place: Point) -> Vector:
    """Return the vector from a body to the nearest point on a side of its path [m]."""
    x, y = place
    ax, ay, dx, dy = points[side, 0], points[side, 1], points[side + 1, 0], points[side + 1, 1]
    dx, dy = dx - ax, dy - ay
    length2 = dx * dx + dy * dy
    share = ((x - ax) * dx + (y - ay) * dy) / length2 if length2 > 0.0 else 0.0
    share = min(max(share, 0.0), 1.0)
    return ax + share * dx - x, ay + share * dy - y


@kernel
def off_way(way: Floats, n_points: int, point: Point, most: float) -> tuple[float, float]:
    """Return how far a point is from a way, and how far along the way the nearest point on it is [m].

    A body that drives ``most`` gets no farther along: the rest of the way, which may come near again behind a wall,
    does not count. The way goes on straight behind its beginning.

    Args:
        way: x and y of its points [m], shape ``(2, n)``.
        n_points: Number of points.
        point: The point [m].
        most: How much of the way counts [m].
    """
    x, y = point
    best2, reached, driven = np.inf, 0.0, 0.0
    for i in range(n_points - 1):
        if driven > most:
            break
        dx, dy = way[0, i + 1] - way[0, i], way[1, i + 1] - way[1, i]
        length = np.sqrt(dx * dx + dy * dy)
        if length == 0.0:
            continue
        from_x, from_y = x - way[0, i], y - way[1, i]
        # The projection on this side, no farther than its end and than the body gets.
        along = min((from_x * dx + from_y * dy) / length, length, most - driven)
        # Only the first side extends backwards without end.
        if i > 0:
            along = max(along, 0.0)
        from_x, from_y = from_x - along / length * dx, from_y - along / length * dy
        if from_x * from_x + from_y * from_y < best2:
            best2, reached = from_x * from_x + from_y * from_y, driven + along
        driven += length
    # The way has no side with a length: a single place.
    if best2 == np.inf:
        return float(np.hypot(x - way[0, 0], y - way[1, 0])), 0.0
    return float(np.sqrt(best2)), reached


@kernel
def way_length(way: Floats, n_points: int) -> float:
    """Return the length of a way [m]; arguments as for ``off_way``."""
    total = 0.0
    for i in range(n_points - 1):
        dx, dy = way[0, i + 1] - way[0, i], way[1, i + 1] - way[1, i]
        total += np.sqrt(dx * dx + dy * dy)
    return total
