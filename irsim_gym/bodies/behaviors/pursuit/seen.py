"""Pursuit by a body's own scans: it remembers hit points, and assumes that unknown space is free."""

from typing import Any

import numpy as np

from irsim_gym.bodies.behaviors.pursuit.drive import is_under_way, pursue
from irsim_gym.bodies.behaviors.pursuit.tables import TIGHT, PursuitTables
from irsim_gym.bodies.behaviors.pursuit.way import place_on_way
from irsim_gym.bodies.behaviors.shared.steering import clear_command
from irsim_gym.simulator.paths.clearance import Obstacles, room_at, way_is_free
from irsim_gym.simulator.paths.points import PointMap, add_point, forget_points, points_of
from irsim_gym.simulator.world.names import Floats, Ints, Model, OwnScan, State, find_hits, kernel, row_of


@kernel
def pursue_seen(
    worlds: Ints,
    slot: int,
    members: Ints,
    params: Any,
    tables: PursuitTables,
    scan: OwnScan,
    model: Model,
    state: State,
) -> None:
    """Write the commands of bodies that know what their scans have shown, and remember the latest.

    Reads: tables (back, by_rate, coarse, count, fine, goal, hits, margin, points, retry, seen, side, standing, whole),
        scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors), model (has_goal, present, reach), state
        (arrived, goal, pose, step, stopped).
    Writes: tables (back, coarse, count, fine, goal, hits, margin, points, retry, seen, side, whole), state (command).
    """
    nothing = tables.standing[slot]
    for w in worlds:
        for k in range(members.shape[0]):
            b, m = members[k], params[k].index
            clear_command(state, w, b)
            points = points_of(tables.seen, w, m)
            note_scan(scan, w, k, b, state, points, tables.hits[slot])
            if not is_under_way(model, state, w, b):
                continue
            # No bodies and no map: `nothing` has no flag set.
            obstacles = Obstacles(model, state, w, nothing, None, points)
            if tables.count[w, m] == 0 and state.step[w] >= tables.retry[w, m]:
                # Without a way, old points may be to blame: only the latest scan is kept.
                forget_points(tables.seen, w, m)
                note_scan(scan, w, k, b, state, points, tables.hits[slot])
            elif way_is_blocked(obstacles, model.reach[row_of(model.reach, w), b], tables, w, m, b):
                # A goal unlike any other makes pursue look for a new way.
                tables.goal[w, m, 0] = np.nan
            pursue(obstacles, obstacles, params[k], tables, slot, b)


@kernel
def note_scan(scan: OwnScan, w: int, k: int, b: int, state: State, points: PointMap, hits: Floats) -> None:
    """Add what the latest scan of a member hit to the points that it remembers.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors), state (pose).
    Writes: points, hits.

    Args:
        scan: The scans.
        w: World.
        k: The member.
        b: Its body.
        state: Current state of the worlds.
        points: Changed.
        hits: Scratch, shape ``(2, n_beams)``.
    """
    x, y, heading = state.pose[w, b, 0], state.pose[w, b, 1], state.pose[w, b, 2]
    cosine, sine = np.cos(heading), np.sin(heading)
    for i in range(find_hits(scan, w, k, np.inf, hits)):
        ahead, aside = hits[0, i], hits[1, i]
        hit = x + cosine * ahead - sine * aside, y + sine * ahead + cosine * aside
        # Nothing is cleared along the beams: one that passes a corner would erase it.
        add_point(points, hit, (x, y))


@kernel
def way_is_blocked(obstacles: Obstacles, reach: float, tables: PursuitTables, w: int, m: int, b: int) -> bool:
    """Return whether something is in what remains of a member's way, nearer than half of what the way keeps away.

    The body itself and its goal may be nearer.

    Reads: tables (count, margin, points, side).
    """
    way, count, pose = tables.points[w, m], tables.count[w, m], obstacles.state.pose[w, b]
    if count == 0:
        return False
    side, place = place_on_way(way, count, tables.side[w, m], (pose[0], pose[1]))
    far = reach + 0.5 * tables.margin[w, m]
    for i in range(side + 1, count):
        radius, point = far, (way[i, 0], way[i, 1])
        # The first side begins where the body is, which may be closer to something already.
        if i == side + 1:
            radius = min(radius, TIGHT * room_at(obstacles, place, far))
        # The goal may lie as close to something as the body fits.
        if i == count - 1:
            radius = min(radius, max(TIGHT * room_at(obstacles, point, far), reach))
        if not way_is_free(obstacles, radius, place, point):
            return True
        place = point
    return False
