"""The paths of the members of a group, and the tables for planning them."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from irsim_gym.bodies.behaviors.shared.steering import commanded_by_rate
from irsim_gym.simulator.paths.clearance import Obstacles, room_at, way_is_free
from irsim_gym.simulator.paths.geodesic import shortest_path
from irsim_gym.simulator.paths.grid import Grid, Search
from irsim_gym.simulator.paths.points import PointMap, forget_points
from irsim_gym.simulator.world.names import Bytes, Flags, Floats, Group, Ints, Model, Point, Struct, kernel

MOST_POINTS = 256
"""Maximum number of stored points of a path; a longer path is planned again at their end."""
COARSE, FINE = 0.5, 0.25
"""Cell size of the path search, as a share of the smallest member's reach."""
SEEN = 0.25
"""Cell size of the maps of seen points, as a share of the smallest member's reach."""
PATIENCE = 10
"""Number of steps after which a body plans again if it found no path, or could not follow it."""
TIGHT = 0.999
"""Share of its distance from an obstacle that a body keeps if it is too close."""
RINGS, DIRECTIONS = 8, 16
"""Number of places that are tried around an end of a path that is too close to an obstacle."""
HALVINGS = 3
"""How often the clearance is halved if there is no path, first on the coarse cells, then on the fine ones."""


class WayGrid(NamedTuple):
    """A grid for searching paths, and its memory; the first axis is the slot.

    Attributes:
        grid: The grid.
        blocked: See ``simulator.paths.grid.Search``.
        field: See ``simulator.paths.grid.Search``.
        queue: See ``simulator.paths.grid.Search``.
        path: Points of a computed path [m], shape ``(n_slots, n_points, 2)``.
    """

    grid: Grid
    blocked: Bytes
    field: Floats
    queue: Ints
    path: Floats

    @classmethod
    def over(cls, bounds: Floats, cell: float, n_slots: int) -> Self:
        """Return a grid over the world with a cell size [m]; memory is claimed from the system when used."""
        grid = Grid.over(bounds, cell)
        n_cells = grid.rows * grid.columns
        shape = (n_slots, grid.rows, grid.columns)
        # As Grid.search and Grid.path return, with a slot axis in front.
        queue, path = np.zeros((n_slots, 3, n_cells + 8), np.int64), np.zeros((n_slots, n_cells + 64, 2))
        return cls(grid, np.zeros(shape, np.uint8), np.zeros(shape), queue, path)


@dataclass(repr=False)
class PursuitTables(Struct):
    """The paths of the members, and the tables for planning them.

    Attributes:
        coarse: Where ways are looked for.
        fine: Where they are looked for at last.
        by_rate: Members whose second number of a command is a turn rate of a car, shape ``(n_members,)``.
        goal: Where each way leads [m], NaN without one, shape ``(n_worlds, n_members, 2)``; the first two axes are the
            same in all that follow.
        points: Points of the way [m], shape ``(n_worlds, n_members, MOST_POINTS, 2)``.
        count: Number of its points, 0 if there is none.
        whole: All of its points are kept.
        margin: How far it keeps the body's surface from what stands [m].
        side: The side of the way on which the body is.
        back: Steps for which a car goes on to drive back.
        retry: The step from which on a way may be looked for again.
        seen: What the members' scans have hit: ``places`` have the shape ``(n_worlds, n_members, columns, rows, 2)``;
            none without scans.
        hits: Scratch: what one scan hits, shape ``(n_slots, 2, n_beams)``.
        standing: Scratch: what stands in the way, shape ``(n_slots, n_bodies)``.
        everything: Scratch: that, and what moves, shape ``(n_slots, n_bodies)``.
    """

    coarse: WayGrid
    fine: WayGrid
    by_rate: Flags
    goal: Floats
    points: Floats
    count: Ints
    whole: Flags
    margin: Floats
    side: Ints
    back: Ints
    retry: Ints
    seen: PointMap
    hits: Floats
    standing: Flags
    everything: Flags

    @classmethod
    def reserve(cls, group: Group, model: Model, n_slots: int) -> Self:
        """Return memory for the members of a group; nobody has a way yet."""
        shape, n_bodies = (len(model.present), len(group.members)), len(model.role)
        reach = float(model.reach[:, group.members].min())
        cells = [reach * COARSE, reach * FINE]
        if (given := [options.cell for options in group.options if options.cell is not None]) != []:
            cells = [min(given), 0.5 * min(given)]
        return cls(
            coarse=WayGrid.over(model.bounds, cells[0], n_slots),
            fine=WayGrid.over(model.bounds, cells[1], n_slots),
            by_rate=commanded_by_rate(group),
            goal=np.full((*shape, 2), np.nan),
            points=np.zeros((*shape, MOST_POINTS, 2)),
            count=np.zeros(shape, np.int64),
            whole=np.zeros(shape, np.bool_),
            margin=np.zeros(shape),
            side=np.zeros(shape, np.int64),
            back=np.zeros(shape, np.int64),
            retry=np.zeros(shape, np.int64),
            seen=PointMap.over(model.bounds, reach * SEEN, (0, 0) if group.scan is None else shape),
            hits=np.zeros((n_slots, 2, 0 if group.scan is None else group.scan.ranges.shape[2])),
            standing=np.zeros((n_slots, n_bodies), np.bool_),
            everything=np.zeros((n_slots, n_bodies), np.bool_),
        )


@kernel
def forget_ways(worlds: Ints, tables: PursuitTables) -> None:
    """Forget all ways of some worlds, and what was seen there.

    Writes: tables (back, goal, retry, seen).
    """
    for w in worlds:
        for m in range(tables.retry.shape[1]):
            tables.goal[w, m, 0], tables.retry[w, m], tables.back[w, m] = np.nan, 0, 0
            if tables.seen.places.shape[0] > 0:
                forget_points(tables.seen, w, m)


@kernel
def find_way(
    obstacles: Obstacles,
    reach: float,
    margin: float,
    ends: tuple[Point, Point],
    tables: PursuitTables,
    slot: int,
    m: int,
) -> None:
    """Write a member's way from its place to its goal, as far from what stands as asked for if there is one.

    Else at half the distance, at a quarter, and on finer cells at less and less; at last as near as it gets.

    Reads: tables (coarse, fine).
    Writes: tables (coarse, count, fine, goal, margin, points, side, whole).

    Args:
        obstacles: What is in the way; the world is theirs.
        reach: Radius of the body [m].
        margin: How far its surface is to keep from obstacles [m].
        ends: Its place and its goal [m].
        tables: Written.
        slot: Whose scratch memory.
        m: The member.
    """
    w, count, coarse, fine = obstacles.w, 0, tables.coarse, tables.fine
    search, path = Search(coarse.blocked[slot], coarse.field[slot], coarse.queue[slot]), coarse.path[slot]
    for _ in range(HALVINGS):
        count = way_between(obstacles, reach + margin, ends, coarse.grid, search, path)
        if count > 0:
            break
        margin *= 0.5
    if count == 0:
        search, path = Search(fine.blocked[slot], fine.field[slot], fine.queue[slot]), fine.path[slot]
    for attempt in range(HALVINGS):
        if count > 0:
            break
        # The coarse cells have left a halved margin. The first try takes it, the next halves it, the last has none.
        margin = margin * 0.5 if 0 < attempt < HALVINGS - 1 else margin
        margin = 0.0 if attempt == HALVINGS - 1 else margin
        count = way_between(obstacles, reach + margin, ends, fine.grid, search, path)
    length = min(count, MOST_POINTS)
    for i in range(length):
        tables.points[w, m, i, 0], tables.points[w, m, i, 1] = path[i, 0], path[i, 1]
    # The way may end beside the goal, see way_between; it still leads to this goal.
    tables.goal[w, m, 0], tables.goal[w, m, 1] = ends[1][0], ends[1][1]
    tables.count[w, m], tables.whole[w, m], tables.margin[w, m] = length, length == count, margin
    tables.side[w, m] = 0


@kernel
def way_between(
    obstacles: Obstacles, radius: float, ends: tuple[Point, Point], grid: Grid, search: Search, path: Floats
) -> int:
    """Write ``shortest_path`` and return its number of points, also where the ends are too near to something.

    There it leads straight to a place near the end where a body of this radius may stand.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: search, path.
    """
    begin, end = place_beside(obstacles, radius, ends[0]), place_beside(obstacles, radius, ends[1])
    count = shortest_path(obstacles, radius, begin, end, grid, search, path)
    if count == 0:
        return 0
    # `path` has room for more points than shortest_path writes.
    if end[0] != ends[1][0] or end[1] != ends[1][1]:
        path[count, 0], path[count, 1] = ends[1][0], ends[1][1]
        count += 1
    if begin[0] != ends[0][0] or begin[1] != ends[0][1]:
        for i in range(count, 0, -1):
            path[i, 0], path[i, 1] = path[i - 1, 0], path[i - 1, 1]
        path[0, 0], path[0, 1] = ends[0][0], ends[0][1]
        count += 1
    return count


@kernel
def place_beside(obstacles: Obstacles, radius: float, end: Point) -> Point:
    """Return the point ``end`` [m], or a nearby one in a straight line if a body of the radius does not fit there.

    On this line the body comes no nearer to anything than at ``end``. Return ``end`` if there is no such point.

    Reads: obstacles (blocks, cells, model, state, w).
    """
    room = room_at(obstacles, end, 2.0 * radius)
    if room > radius:
        return end
    for ring in range(1, RINGS + 1):
        away = radius * ring / RINGS
        for k in range(DIRECTIONS):
            angle = 2.0 * np.pi * k / DIRECTIONS
            place = (end[0] + away * np.cos(angle), end[1] + away * np.sin(angle))
            # On the way between the two, the body may come as close as it is at `end`, but for rounding.
            if room_at(obstacles, place, 2.0 * radius) > radius and way_is_free(obstacles, TIGHT * room, end, place):
                return place
    return end
