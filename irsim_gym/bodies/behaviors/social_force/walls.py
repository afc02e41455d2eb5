"""Social forces: the pushes of walls and of a map's discs on a body.

The push of a wall is that of Helbing and Molnar (1995).
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from irsim_gym.base.arraytypes import BodyOutline, Flags, Floats, Ints, Point, Record, Records, Vector
from irsim_gym.bodies.behaviors.shared.map_parts import map_discs, map_walls, most_map_discs, most_map_walls
from irsim_gym.bodies.behaviors.shared.surroundings import MARGIN, is_seen, wall_bodies
from irsim_gym.simulator.geometry.segments import side
from irsim_gym.simulator.world.names import Group, Model, State, Struct, kernel, record_type, row_of

FADED = 5.0
"""Walls farther away than this many decay lengths do not push."""

TOUCHING = 1e-9
"""Nearer than this [m] a wall has no direction: it pushes along x."""

WALL_POINT = record_type("gap2 x y")
"""The nearest point of what pushes one way in a map: its squared distance [m2] and its place [m]."""


@dataclass
class SocialTables(Struct):
    """Tables for the forces on the members of a group; each shard has its own.

    Attributes:
        by_hypot: Whether to round lengths like IR-SIM's group rather than like its single body.
        among: Whether each body walks in the group, whatever its role, shape ``(body,)``.
        lines: Bodies that are chains of segments, shape ``(n_lines,)``.
        nearby: Scratch for a search of bodies, shape ``(body,)``.
        sides: Scratch for the walls of a map: x0, y0, x1, y1 [m], shape ``(n, 4)``.
        discs: Scratch for the discs of a map: x, y, radius [m], shape ``(n, 3)``.
        nearest: Scratch: records of type ``WALL_POINT``, one for each of the four directions in which walls face, in
            any order; shape ``(4,)``.
    """

    by_hypot: bool
    among: Flags
    lines: Ints
    nearby: Ints
    sides: Floats
    discs: Floats
    nearest: Records

    @classmethod
    def reserve(cls, group: Group, model: Model, *, together: bool) -> Self:
        """Allocate memory for one shard; ``together`` means that the members are one group."""
        reach = FADED * max(options.sigma_obstacle for options in group.options) + float(model.reach.max()) + MARGIN
        among = np.zeros(len(model.role), np.bool_)
        among[group.members] = together
        return cls(
            by_hypot=together,
            among=among,
            lines=wall_bodies(model),
            nearby=np.zeros(len(model.role), np.int64),
            sides=np.zeros((most_map_walls(model, reach), 4)),
            discs=np.zeros((most_map_discs(model, reach + model.map_disc[0]), 3)),
            nearest=np.zeros(4, WALL_POINT),
        )


@kernel
def push_of_wall(dx: float, dy: float, r: float, sigma: float) -> Vector:
    """Return the push of a wall whose nearest point lies at (-dx, -dy) [m] from the centre of a disc of radius r.

    It fades with the gap between them as exp(-gap / sigma) (Helbing and Molnar 1995).
    """
    distance = np.sqrt(dx * dx + dy * dy)
    if distance < TOUCHING:
        return 1.0, 0.0
    size = np.exp(-max(distance - r, 0.0) / sigma)
    return size * dx / distance, size * dy / distance


@kernel
def push_of_lines(model: Model, state: State, w: int, b: int, options: Any, tables: SocialTables) -> Vector:
    """Return the push of the segments of all linestrings; each segment pushes on its own.

    Reads: model (heedless, movable, present, radius, role, seen_row, segment_count, segment_start, watchers), state
        (pose, segments), tables (among, lines).
    """
    x, y = state.pose[w, b, 0], state.pose[w, b, 1]
    r = model.radius[row_of(model.radius, w), b] + MARGIN
    reach = FADED * options.sigma_obstacle + r
    sum_x, sum_y = 0.0, 0.0
    for q in tables.lines:
        if tables.among[q] or not is_seen(model, w, b, q, options.target_roles):
            continue
        s = model.segment_start[q]
        for i in range(s, s + model.segment_count[row_of(model.segment_count, w), q]):
            cx, cy = foot_on(x, y, state.segments[w, i])
            if np.sqrt((x - cx) * (x - cx) + (y - cy) * (y - cy)) <= reach:
                fx, fy = push_of_wall(x - cx, y - cy, r, options.sigma_obstacle)
                sum_x, sum_y = sum_x + fx, sum_y + fy
    return sum_x, sum_y


@kernel
def push_of_map(model: Model, state: State, w: int, b: int, options: Any, tables: SocialTables) -> Vector:
    """Return the push of an occupancy map: that of the nearest wall that faces each of the four directions.

    Each wall counts once, however fine the cells are, and the two walls of a corridor cancel in its middle. Walls that
    push the same way, such as the two of a corner or the steps of a slanted wall, count once too: only the strongest
    push to each of the four sides acts. Discs count as walls: the nearest disc on each side of the body, up to half a
    right angle from it, pushes from its nearest point. As standing bodies, each of which pushes a fifth as hard
    as a wall, the discs of a row would add up.

    Reads: model (map_disc, map_frame, map_squares, radius), state (pose), tables (discs, nearest, sides).
    Writes: tables (discs, nearest, sides).
    """
    x, y, nearest = state.pose[w, b, 0], state.pose[w, b, 1], tables.nearest
    r = model.radius[row_of(model.radius, w), b] + MARGIN
    reach = FADED * options.sigma_obstacle + r
    for way in range(4):
        nearest[way].gap2 = reach * reach
    find_nearest_walls(model, w, x, y, reach, tables)
    find_nearest_discs(model, w, x, y, reach, tables)
    left, right, down, up = 0.0, 0.0, 0.0, 0.0
    for way in range(4):
        if nearest[way].gap2 < reach * reach:
            fx, fy = push_of_wall(x - nearest[way].x, y - nearest[way].y, r, options.sigma_obstacle)
            # The strongest push to each side; pushes to opposite sides add up with their signs.
            left, right, down, up = min(left, fx), max(right, fx), min(down, fy), max(up, fy)
    return left + right, down + up


@kernel
def find_nearest_walls(model: Model, w: int, x: float, y: float, reach: float, tables: SocialTables) -> None:
    """Note the nearest points of a map's walls within ``reach`` [m], one for each direction that walls face.

    Reads: model (map_disc, map_frame, map_squares), tables (nearest, sides).
    Writes: tables (nearest, sides).
    """
    sides = tables.sides
    for k in range(map_walls(model, w, x, y, reach, sides, 0)):
        ax, ay, bx, by = sides[k]
        # Free cells are to the left of a wall, so one that has the body to its right faces away from it. The number of
        # the direction: lines along x before lines along y, each by its sense.
        if side(ax, ay, bx, by, x, y) >= 0.0:
            note_nearest((x, y), foot_on(x, y, sides[k]), tables.nearest[2 * int(ax == bx) + int(bx < ax or by < ay)])


@kernel
def find_nearest_discs(model: Model, w: int, x: float, y: float, reach: float, tables: SocialTables) -> None:
    """Note the nearest points of a map's discs within ``reach`` [m], one for each side; skip discs that hold (x, y).

    Reads: model (map_disc, map_frame, map_squares), tables (discs, nearest).
    Writes: tables (discs, nearest).
    """
    discs = tables.discs
    for d in range(map_discs(model, w, x, y, reach + model.map_disc[0], discs)):
        dx, dy, radius = x - discs[d, 0], y - discs[d, 1], discs[d, 2]
        off = np.sqrt(dx * dx + dy * dy)
        if off > radius:
            share = radius / off
            # The larger offset decides to which side of the disc the body is.
            way = 2 + int(dx < 0.0) if np.abs(dx) > np.abs(dy) else int(dy < 0.0)
            note_nearest((x, y), (discs[d, 0] + share * dx, discs[d, 1] + share * dy), tables.nearest[way])


@kernel
def note_nearest(body: Point, point: Point, nearest: Record) -> None:
    """Note a point if it is nearer to a body [m] than the noted one."""
    dx, dy = body[0] - point[0], body[1] - point[1]
    gap2 = dx * dx + dy * dy
    if gap2 < nearest.gap2:
        nearest.gap2, nearest.x, nearest.y = gap2, point[0], point[1]


@kernel
def nearest_point(x: float, y: float, outline: BodyOutline) -> Point:
    """Return the point of an outline that is nearest to the point (x, y) [m]."""
    best, best_x, best_y = np.inf, x, y
    for i in range(outline.first_segment, outline.first_segment + outline.n_segments):
        cx, cy = foot_on(x, y, outline.segments[i])
        distance = np.sqrt((x - cx) * (x - cx) + (y - cy) * (y - cy))
        if distance < best:
            best, best_x, best_y = distance, cx, cy
    for i in range(outline.first_disc, outline.first_disc + outline.n_discs):
        disc = outline.discs[i]
        dx, dy, radius = x - disc[0], y - disc[1], disc[2]
        off = np.sqrt(dx * dx + dy * dy)
        if off > 0.0 and np.abs(off - radius) < best:
            best, share = np.abs(off - radius), radius / off
            best_x, best_y = disc[0] + share * dx, disc[1] + share * dy
    return best_x, best_y


@kernel
def foot_on(x: float, y: float, segment: Floats) -> Point:
    """Return the point of a segment that is nearest to a point [m]."""
    ax, ay = segment[0], segment[1]
    dx, dy = segment[2] - ax, segment[3] - ay
    length2 = dx * dx + dy * dy
    if length2 < 1e-12:
        return ax, ay
    share = max(0.0, min(1.0, ((x - ax) * dx + (y - ay) * dy) / length2))
    return ax + share * dx, ay + share * dy
