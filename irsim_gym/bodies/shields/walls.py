"""The walls that a scan shows: lines from beam to beam, in which nothing gets lost between two of them."""

import numpy as np

from irsim_gym.bodies.shields.tables import ShieldTables
from irsim_gym.simulator.geometry.overlap import is_round, outline_distance
from irsim_gym.simulator.geometry.segments import point_segment_distance2, segment_segment_distance2
from irsim_gym.simulator.world.names import BodyOutline, Floats, Model, Rays, State, kernel, own_outline, row_of

TOLERANCE = 5e-4
"""Added to the margin [m], so that small errors of ranges, corners and braking may add up."""
NEAREST = 1e-3
"""Shorter ranges count as this [m]."""
FLAT = 3e-4
"""Points that lie on one line up to this share of their inverse range are of one surface."""
NEAR = 0.2 * TOLERANCE
"""Guesses end this far from the body [m]."""
HALVINGS = 10
"""Steps in which the length of a guess is found."""
ROUNDING = 1e-9
"""Rounding errors of distances [m] are far smaller."""

Pose = tuple[float, float, float]
"""x, y [m] and heading [rad], in the frame of the body as it is now."""


@kernel
def lay_walls(w: int, k: int, slot: int, travel: float, tables: ShieldTables, model: Model, state: State) -> int:
    """Write the walls that member k may come near to, and how near it may; return their number.

    Two neighbouring beams give a line between the points that they hit, and two more to a corner that may stand out
    between them (``corner_between``).

    Reads: tables (margin, members, scan, walls), model (disc_count, disc_start, local_discs, local_segments, reach,
        segment_count, segment_start, solid).
    Writes: tables (need, walls).

    Args:
        w: The world.
        k: The member.
        slot: Whose scratch memory.
        travel: How far the body goes at most [m].
        tables: The members.
        model: Constants of the worlds.
        state: State of the worlds.
    """
    scan, b = tables.scan, tables.members[k]
    s, outline, count = scan.sensors[k], own_outline(model, w, b), 0
    ranges, angles, x, y = scan.ranges[w, s], scan.angles[s], scan.offset[s, 0], scan.offset[s, 1]
    walls, need, margin = tables.walls[slot], tables.need[slot], tables.margin[k] + TOLERANCE
    within = model.reach[row_of(model.reach, w), b] + travel + margin
    for i in range(ranges.shape[0] - 1):
        begin, end = max(float(ranges[i]), NEAREST), max(float(ranges[i + 1]), NEAREST)
        corner, share = corner_between(ranges, i, angles[i + 1] - angles[i], scan.range_max[s])
        turn = angles[i] + share * (angles[i + 1] - angles[i])
        ax, ay = x + begin * scan.beams_x[s, i], y + begin * scan.beams_y[s, i]
        bx, by = x + end * scan.beams_x[s, i + 1], y + end * scan.beams_y[s, i + 1]
        cx, cy = x + corner * np.cos(turn), y + corner * np.sin(turn)
        for part in range(3 if corner > 0.0 else 1):
            row = walls[count]
            row[0], row[1] = (bx, by) if part == 2 else (ax, ay)
            row[2], row[3] = (cx, cy) if part > 0 else (bx, by)
            if point_segment_distance2(0.0, 0.0, row[0], row[1], row[2], row[3]) < within * within:
                need[count] = gap_to(row, outline, part > 0, margin, walls, count)
                count += 1
    return count


@kernel
def gap_to(wall: Floats, outline: BodyOutline, is_guess: bool, margin: float, walls: Floats, j: int) -> float:
    """Return the distance of a body from a wall in its own frame, at most ``margin`` [m].

    A guess that the body would touch is shortened: nothing stands there. Anything else that it touches is an error of
    the scan, and its distance of 0 can be kept.

    Writes: wall.

    Args:
        wall: The wall, row ``j`` of ``walls``.
        outline: The outline of the body.
        is_guess: The second end is a corner that no beam has hit.
        margin: The distance that matters [m].
        walls: The table of walls.
        j: The row.
    """
    gap = outline_distance(outline, wall_outline(walls, j, outline), margin)
    x, y, low, high = wall[2], wall[3], 0.0, 1.0
    if gap >= NEAR or not is_guess:
        return gap
    for step in range(HALVINGS + 1):
        share = low if step == HALVINGS else 0.5 * (low + high)
        wall[2], wall[3] = wall[0] + share * (x - wall[0]), wall[1] + share * (y - wall[1])
        gap = outline_distance(outline, wall_outline(walls, j, outline), margin)
        low, high = (share, high) if gap >= NEAR else (low, share)
    return gap


@kernel
def corner_between(ranges: Rays, i: int, step: float, far: float) -> tuple[float, float]:
    """Return where a corner may stand out between two beams: its range [m], 0 for none, and where between them, 0 to 1.

    On a line, inverse ranges u of evenly spread beams obey u[i + 1] = 2 cos(step) u[i] - u[i - 1]. So the surfaces to
    either side of the pair are continued. Where they meet between the beams, there may be a corner; where one of them
    passes in front of the other beam's point, it may end right before that beam.

    Args:
        ranges: Ranges of all beams [m].
        i: The first beam of the pair.
        step: Angle between the beams [rad].
        far: Range of a beam that hits nothing [m].
    """
    left, right = 1.0 / max(float(ranges[i]), NEAREST), 1.0 / max(float(ranges[i + 1]), NEAREST)
    rise, knows_left = slope_at(ranges, i, 1, step)
    fall, knows_right = slope_at(ranges, i + 1, -1, step)
    above, behind = left + rise - right, right + fall - left
    flat = FLAT * max(left, right)
    if (knows_left and np.abs(above) < flat) or (knows_right and np.abs(behind) < flat):
        return 0.0, 0.0  # one surface
    if above > 0.0 and behind > 0.0 and knows_left and knows_right:
        share = behind / (rise + fall)
        # Between two beams a line is nearer than a mean of inverse ranges says, by this factor at most.
        return np.cos(0.5 * step) / (left + share * rise), share
    if above > 0.0 and (behind <= 0.0 or knows_left):
        return (1.0 / (left + rise), 1.0) if ranges[i] < far else (0.0, 0.0)
    return (1.0 / (right + fall), 0.0) if ranges[i + 1] < far else (0.0, 0.0)


@kernel
def slope_at(ranges: Rays, i: int, way: int, step: float) -> tuple[float, bool]:
    """Return by how much the inverse range grows from beam i to the next on the surface that it has hit [1/m].

    It is 0, as for a surface that goes on at the same range, if the surface turns away from the sensor, and if three
    beams do not agree, because the one before i has hit something else. The flag says that they do.

    Args:
        ranges: Ranges of all beams [m].
        i: The beam.
        way: 1 for the next beam in their order, -1 for the one before.
        step: Angle between the beams [rad].
    """
    if not 0 <= i - 2 * way < ranges.shape[0]:
        return 0.0, False
    bend = 2.0 - 2.0 * np.cos(step)
    u, before = 1.0 / max(float(ranges[i]), NEAREST), 1.0 / max(float(ranges[i - way]), NEAREST)
    earlier = 1.0 / max(float(ranges[i - 2 * way]), NEAREST)
    # On a line, both are equal up to ``bend * u``.
    slope, slope_before = (1.0 - bend) * u - before, (1.0 - bend) * before - earlier
    agree = slope <= slope_before + FLAT * u
    return max(slope, 0.0) if agree else 0.0, agree


@kernel
def turned_wall(wall: Floats, pose: Pose, into: Floats) -> None:
    """Write a wall as a body at a pose sees it, in its own frame.

    Writes: into.
    """
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    for c in (0, 2):
        x, y = wall[c] - pose[0], wall[c + 1] - pose[1]
        into[c], into[c + 1] = cosine * x + sine * y, cosine * y - sine * x


@kernel
def is_too_near(
    outline: BodyOutline, reach: float, way: tuple[Pose, Pose], walls: Floats, need: Floats, n: int
) -> bool:
    """Return whether a body on its way from one pose to another comes nearer to a wall than it may.

    A disc about the origin counts all along the way, other outlines at its end.

    Args:
        outline: The outline in the body frame.
        reach: Radius about its origin that holds it [m].
        way: The two poses.
        walls: Walls [m], shape ``(n_walls + 1, 4)``; the last row is scratch.
        need: Distances that have to remain [m], shape ``(n_walls,)``.
        n: How many of them count.
    """
    begin, end, last = way[0], way[1], walls.shape[0] - 1
    for j in range(n):
        ax, ay, bx, by, least = walls[j, 0], walls[j, 1], walls[j, 2], walls[j, 3], need[j] - ROUNDING
        gap2 = segment_segment_distance2(begin[0], begin[1], end[0], end[1], ax, ay, bx, by)
        if least <= 0.0 or gap2 >= (reach + least) * (reach + least):
            continue
        if is_round(outline):
            return True
        turned_wall(walls[j], end, walls[last])
        if outline_distance(outline, wall_outline(walls, last, outline), least) < least:
            return True
    return False


@kernel
def wall_outline(walls: Floats, j: int, outline: BodyOutline) -> BodyOutline:
    """Return a wall as an outline; ``outline`` lends a table of discs, of which it has none."""
    return BodyOutline(walls, j, 1, outline.discs, 0, 0, False)
