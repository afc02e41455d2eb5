"""Shortens a free path while keeping it free."""

import numpy as np

from irsim_gym.base.arraytypes import Floats, Point
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.geometry.segments import point_segment_distance2
from irsim_gym.simulator.paths.clearance import Obstacles, way_is_free
from irsim_gym.simulator.paths.points import blocking_point

ROUNDS, SWEEPS, HALVINGS = 4, 4, 6
"""How often points are added about corners; how often all are drawn in after that; steps of the search for how far."""
LONGEST_CUT = 0.5
"""Distance from a corner at which points are added in the first round [m]; it halves in each later round."""


@kernel
def path_length(path: Floats, count: int) -> float:
    """Return the length [m] of the polyline through the first ``count`` points."""
    total = 0.0
    for i in range(1, count):
        dx, dy = path[i, 0] - path[i - 1, 0], path[i, 1] - path[i - 1, 1]
        total += np.sqrt(dx * dx + dy * dy)
    return total


@kernel
def pull(obstacles: Obstacles, radius: float, path: Floats, count: int) -> int:
    """Shorten a free path in place and return its new number of points. It stays free.

    Unneeded points are removed. Then points are added on both sides of each corner, and all inner points are drawn
    towards the chord of their neighbours as far as both sides stay free. So the path bends around obstacles.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: path.

    Args:
        obstacles: What is in the way.
        radius: Radius of the moving body [m].
        path: Changed: the points [m], shape ``(n_points, 2)``; room for more than ``count`` is used.
        count: Number of points.
    """
    count = skip_points(obstacles, radius, path, count)
    cut = LONGEST_CUT
    for _ in range(ROUNDS):
        count = flank_corners(path, count, cut)
        cut *= 0.5
        for _ in range(SWEEPS):
            for i in range(1, count - 1):
                draw_in(obstacles, radius, path, i)
        count = skip_points(obstacles, radius, path, count)
    return count


@kernel
def skip_points(obstacles: Obstacles, radius: float, path: Floats, count: int) -> int:
    """Connect each kept point to the last one that it reaches on a free straight line; return the number of points.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: path.
    """
    count_left, place = 1, 0
    while place < count - 1:
        to, start, blocker = count - 1, (path[count_left - 1, 0], path[count_left - 1, 1]), (np.nan, np.nan)
        # The next point is always free to reach, as the path is free.
        while to > place + 1:
            free, blocker = is_free(obstacles, radius, start, (path[to, 0], path[to, 1]), blocker)
            if free:
                break
            to -= 1
        path[count_left, 0], path[count_left, 1] = path[to, 0], path[to, 1]
        count_left, place = count_left + 1, to
    return count_left


@kernel
def flank_corners(path: Floats, count: int, cut: float) -> int:
    """Add a point before and after each inner one while there is room; return the new number of points.

    The points lie ``cut`` [m] from the corner, or at a third of a side that is shorter than three times that.
    """
    # Three points for each of count - 2 inner ones, and both ends.
    more = 3 * count - 4
    if count < 3 or more > path.shape[0]:
        return count
    path[more - 1, 0], path[more - 1, 1] = path[count - 1, 0], path[count - 1, 1]
    after_x, after_y = path[count - 1, 0], path[count - 1, 1]
    # From the end, so that no point is overwritten before it is read.
    for i in range(count - 2, 0, -1):
        x, y, before_x, before_y = path[i, 0], path[i, 1], path[i - 1, 0], path[i - 1, 1]
        place = 3 * i - 1
        put_between(path, place + 1, x, y, after_x, after_y, cut)
        path[place, 0], path[place, 1] = x, y
        put_between(path, place - 1, x, y, before_x, before_y, cut)
        after_x, after_y = x, y
    return more


@kernel
def put_between(path: Floats, place: int, ax: float, ay: float, bx: float, by: float, cut: float) -> None:
    """Write a point ``cut`` [m] from a on the way to b, at most a third of the way."""
    dx, dy = bx - ax, by - ay
    length = np.sqrt(dx * dx + dy * dy)
    share = min(1.0 / 3.0, cut / length) if length > 0.0 else 0.0
    path[place, 0], path[place, 1] = ax + share * dx, ay + share * dy


@kernel
def draw_in(obstacles: Obstacles, radius: float, path: Floats, i: int) -> None:
    """Move point i towards the nearest point of its neighbours' chord, as far as both its sides stay free.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: path.
    """
    ax, ay, bx, by, cx, cy = path[i - 1, 0], path[i - 1, 1], path[i, 0], path[i, 1], path[i + 1, 0], path[i + 1, 1]
    dx, dy = cx - ax, cy - ay
    length2 = dx * dx + dy * dy
    share = ((bx - ax) * dx + (by - ay) * dy) / length2 if length2 > 0.0 else 0.0
    share = min(max(share, 0.0), 1.0)
    way_x, way_y = ax + share * dx - bx, ay + share * dy - by
    # Bisection for the greatest free share of the way; the first try is all of it.
    good, step, blocker = 0.0, 1.0, (np.nan, np.nan)
    for _ in range(HALVINGS + 1):
        middle = (bx + (good + step) * way_x, by + (good + step) * way_y)
        free, blocker = is_free(obstacles, radius, (ax, ay), middle, blocker)
        if free:
            free, blocker = is_free(obstacles, radius, middle, (cx, cy), blocker)
        if free:
            good += step
            if good >= 1.0:
                break
        step *= 0.5
    path[i, 0], path[i, 1] = bx + good * way_x, by + good * way_y


@kernel
def is_free(obstacles: Obstacles, radius: float, start: Point, end: Point, blocker: Point) -> tuple[bool, Point]:
    """Return whether a body can go straight between two points, and the next blocker.

    Lines that are tried one after the other are often blocked by the same seen point, so that one is tested first.

    Reads: obstacles (blocks, cells, model, state, w).

    Args:
        obstacles: What is in the way.
        radius: Radius of the moving body [m].
        start: Where it starts [m].
        end: Where it ends [m].
        blocker: The seen point that blocked the previous line [m], (NaN, NaN) for none.
    """
    # NaN fails the comparison.
    if point_segment_distance2(blocker[0], blocker[1], start[0], start[1], end[0], end[1]) <= radius * radius:
        return False, blocker
    hit = blocking_point(obstacles.points, start[0], start[1], end[0], end[1], radius)
    if hit[0] == hit[0]:
        return False, hit
    others = Obstacles(obstacles.model, obstacles.state, obstacles.w, obstacles.blocks, obstacles.cells, None)
    return way_is_free(others, radius, start, end), blocker
