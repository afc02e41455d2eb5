"""Social forces: what pushes a body that walks among others.

The push of other bodies is that of Moussaid et al. (2009), the push of walls and the pull to the goal those of Helbing
and Molnar (1995), with IR-SIM's constants and roundings.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import BodyOutline, Flags, Floats, Ints
from irsim_gym.behaviors.steering import to_command
from irsim_gym.behaviors.surroundings import (
    ALL_ROLES,
    MARGIN,
    ROUND,
    SLACK,
    STANDING,
    Scene,
    centroid_of,
    is_map_seen,
    is_seen,
    look_of,
    map_walls,
)
from irsim_gym.geometry.buckets import find_nearby
from irsim_gym.geometry.overlap import point_outline_distance
from irsim_gym.geometry.segments import side
from irsim_gym.jit import kernel
from irsim_gym.world.rows import row_of

FADED = 5.0
"""Walls farther away than this many decay lengths do not push."""

TOUCHING = 1e-9
"""Nearer than this [m] a wall has no direction: it pushes along x."""

TURN_TOLERANCE, SLOW = 0.02, 0.02
"""How a differential drive follows the planned velocity [rad, m/s]."""


@kernel
def planned_velocity(
    scene: Scene,
    w: int,
    b: int,
    options: Any,
    among: Flags,
    wanted_x: float,
    wanted_y: float,
    extra_x: float,
    extra_y: float,
    step_time: float,
    by_hypot: bool,
    lines: Ints,
    nearby: Ints,
    sides: Floats,
    nearest: Floats,
) -> tuple[float, float]:
    """Return the velocity that follows from all forces in one step [m/s], no faster than ``vmax``.

    Args:
        scene: What there is.
        w: The world.
        b: The body that is pushed.
        options: Its parameters.
        among: The bodies that walk in its group, whatever their role, shape ``(body,)``.
        wanted_x: Velocity towards the goal; its direction counts.
        wanted_y: Velocity towards the goal; its direction counts.
        extra_x: Another force [m/s2].
        extra_y: Another force [m/s2].
        step_time: Duration of the step [s].
        by_hypot: Round lengths as IR-SIM's group does, not as its single body.
        lines: Bodies that are chains of segments.
        nearby: Scratch, shape ``(body,)``.
        sides: Scratch, shape ``(n, 4)``.
        nearest: Scratch, shape ``(4, 3)``.
    """
    vx, vy = scene.twist[w, b, 0], scene.twist[w, b, 1]
    size = length_of(wanted_x, wanted_y, by_hypot)
    if size > 1e-9:
        wanted_x, wanted_y = options.vmax * wanted_x / size, options.vmax * wanted_y / size
    pull_x, pull_y = (wanted_x - vx) / options.relaxation_time, (wanted_y - vy) / options.relaxation_time
    others_x, others_y, walls_x, walls_y = push_of_bodies(scene, w, b, options, among, by_hypot, nearby)
    if lines.shape[0] > 0:
        fx, fy = push_of_lines(scene, w, b, options, among, lines)
        walls_x, walls_y = walls_x + fx, walls_y + fy
    if scene.map_frame[0].body >= 0:
        fx, fy = push_of_map(scene, w, b, options, sides, nearest)
        walls_x, walls_y = walls_x + fx, walls_y + fy
    ax = options.force_factor_desired * pull_x + options.force_factor_social * others_x
    ay = options.force_factor_desired * pull_y + options.force_factor_social * others_y
    ax = ax + options.force_factor_obstacle * walls_x + extra_x
    ay = ay + options.force_factor_obstacle * walls_y + extra_y
    vx, vy = vx + step_time * ax, vy + step_time * ay
    speed = length_of(vx, vy, by_hypot)
    if speed > options.vmax:
        share = options.vmax / speed
        vx, vy = vx * share, vy * share
    return vx, vy


@kernel
def follow(
    drive: int,
    heading: float,
    vx: float,
    vy: float,
    velocity: Floats,
    fastest: Floats,
    acceleration: Floats,
    step_time: float,
    command: Floats,
) -> None:
    """Write the command that follows a velocity within one step, as fast as a differential drive can turn."""
    turn_limit = min(fastest[1], velocity[1] + acceleration[1] * step_time)
    to_command(drive, heading, vx, vy, step_time, TURN_TOLERANCE, SLOW, turn_limit, command)


@kernel
def push_of_bodies(
    scene: Scene, w: int, b: int, options: Any, among: Flags, by_hypot: bool, nearby: Ints
) -> tuple[float, float, float, float]:
    """Return the push of what moves or is a disc (x, y), and that of what stands and has sides (x, y).

    The first is seen up to ``neighbor_threshold`` from centre to centroid; the second pushes once for each body, from
    the nearest point of its outline.
    """
    pose, twist, frame, sight = scene.pose[w], scene.twist[w], scene.bucket_frame[0], options.neighbor_threshold
    role, present = scene.role, scene.present[w]
    n_segments, n_discs = (
        scene.segment_count[row_of(scene.segment_count, w)],
        scene.disc_count[row_of(scene.disc_count, w)],
    )
    centroid, reaches = scene.centroid[row_of(scene.centroid, w)], scene.reach[row_of(scene.reach, w)]
    segments, discs = scene.segments[w], scene.discs[w]
    x, y, vx, vy = pose[b, 0], pose[b, 1], twist[b, 0], twist[b, 1]
    r = scene.radius[row_of(scene.radius, w), b] + MARGIN
    reach = FADED * options.sigma_obstacle + r
    most = max(sight, reach)
    others_x, others_y, walls_x, walls_y = 0.0, 0.0, 0.0, 0.0
    for k in range(find_nearby(x, y, most + frame.reach, frame, scene.bucket_first[w], scene.bucket_next[w], nearby)):
        q = nearby[k]
        dx, dy, far = pose[q, 0] - x, pose[q, 1] - y, most + reaches[q]
        roles = ALL_ROLES if among[q] else options.target_roles
        if dx * dx + dy * dy > far * far * SLACK or not is_seen(b, q, roles, role, present):
            continue
        look = ROUND if among[q] else look_of(n_segments[q], n_discs[q], scene.solid[q], scene.movable[q])
        if look == STANDING:
            s, n, d, m = scene.segment_start[q], n_segments[q], scene.disc_start[q], n_discs[q]
            distance = point_outline_distance(x, y, BodyOutline(segments, s, n, discs, d, m, scene.solid[q]))
            if distance <= reach:
                cx, cy = nearest_point(x, y, segments[s : s + n], discs[d : d + m])
                fx, fy = push_of_wall(x - cx, y - cy, r, options.sigma_obstacle)
                if distance == 0.0:
                    fx, fy = -fx, -fy
                walls_x, walls_y = walls_x + fx, walls_y + fy
        if look == ROUND:
            px, py = (pose[q, 0], pose[q, 1]) if among[q] else centroid_of(pose[q], centroid[q])
            if (x - px) * (x - px) + (y - py) * (y - py) < sight * sight:
                fx, fy = push_of_body(px - x, py - y, vx - twist[q, 0], vy - twist[q, 1], options, by_hypot)
                others_x, others_y = others_x + fx, others_y + fy
    return others_x, others_y, walls_x, walls_y


@kernel
def push_of_body(dx: float, dy: float, ux: float, uy: float, options: Any, by_hypot: bool) -> tuple[float, float]:
    """Return the push of another body at (dx, dy) [m] on one whose velocity relative to it is (ux, uy) [m/s].

    The sideways part changes its sign with the angle between the interaction and the way to the other, at full size.
    Where that angle is 0, as for two bodies at rest, rounding decides on which side a body is pushed.
    """
    distance = length_of(dx, dy, by_hypot)
    if distance < 1e-6:
        return 0.0, 0.0
    to_x, to_y = dx / distance, dy / distance
    tx, ty = options.lambda_importance * ux + to_x, options.lambda_importance * uy + to_y
    size = length_of(tx, ty, by_hypot)
    if size < 1e-9:
        return 0.0, 0.0
    tx, ty = tx / size, ty / size
    scale = options.gamma * size
    angle = np.arctan2(tx * to_y - ty * to_x, tx * to_x + ty * to_y)
    fading = -max(distance - 2.0 * options.safety_radius, 0.0) / scale
    braking, turning = options.n_velocity * scale * angle, options.n_angular * scale * angle
    brake = -np.exp(fading - braking * braking)
    turn = -np.sign(angle) * np.exp(fading - turning * turning)
    return brake * tx - turn * ty, brake * ty + turn * tx


@kernel
def push_of_wall(dx: float, dy: float, r: float, sigma: float) -> tuple[float, float]:
    """Return the push of a wall whose nearest point lies at (-dx, -dy) [m] from the centre of a disc of radius r."""
    distance = np.sqrt(dx * dx + dy * dy)
    if distance < TOUCHING:
        return 1.0, 0.0
    size = np.exp(-max(distance - r, 0.0) / sigma)
    return size * dx / distance, size * dy / distance


@kernel
def push_of_lines(scene: Scene, w: int, b: int, options: Any, among: Flags, lines: Ints) -> tuple[float, float]:
    """Return the push of all segments of linestrings: each pushes by itself."""
    x, y = scene.pose[w, b, 0], scene.pose[w, b, 1]
    r = scene.radius[row_of(scene.radius, w), b] + MARGIN
    reach = FADED * options.sigma_obstacle + r
    sum_x, sum_y = 0.0, 0.0
    for q in lines:
        seen = is_seen(b, q, options.target_roles, scene.role, scene.present[w])
        if among[q] or not seen:
            continue
        s, n = scene.segment_start[q], scene.segment_count[row_of(scene.segment_count, w), q]
        for i in range(s, s + n):
            cx, cy = foot_on(x, y, scene.segments[w, i])
            if np.sqrt((x - cx) * (x - cx) + (y - cy) * (y - cy)) <= reach:
                fx, fy = push_of_wall(x - cx, y - cy, r, options.sigma_obstacle)
                sum_x, sum_y = sum_x + fx, sum_y + fy
    return sum_x, sum_y


@kernel
def push_of_map(scene: Scene, w: int, b: int, options: Any, sides: Floats, nearest: Floats) -> tuple[float, float]:
    """Return the push of an occupancy map: of the nearest wall that looks in each of its four directions.

    Each wall counts once, however fine the cells are, and the two walls of a corridor cancel in its middle. So do walls
    that push the same way, such as the two of a corner and the steps of a slanted wall: of all pushes to one of the
    four sides the strongest holds.
    """
    if not is_map_seen(options.target_roles, scene.map_frame[0], scene.role, scene.present[w]):
        return 0.0, 0.0
    x, y = scene.pose[w, b, 0], scene.pose[w, b, 1]
    r = scene.radius[row_of(scene.radius, w), b] + MARGIN
    reach = FADED * options.sigma_obstacle + r
    n_sides = map_walls(x, y, reach, scene.map_frame[0], scene.map_squares, sides, 0)
    for way in range(4):
        nearest[way, 0] = reach * reach
    for k in range(n_sides):
        ax, ay, bx, by = sides[k]
        if side(ax, ay, bx, by, x, y) < 0.0:
            continue
        way = 2 * int(ax == bx) + int(bx < ax or by < ay)
        cx, cy = foot_on(x, y, sides[k])
        distance2 = (x - cx) * (x - cx) + (y - cy) * (y - cy)
        if distance2 < nearest[way, 0]:
            nearest[way, 0], nearest[way, 1], nearest[way, 2] = distance2, cx, cy
    left, right, down, up = 0.0, 0.0, 0.0, 0.0
    for way in range(4):
        if nearest[way, 0] < reach * reach:
            fx, fy = push_of_wall(x - nearest[way, 1], y - nearest[way, 2], r, options.sigma_obstacle)
            left, right, down, up = min(left, fx), max(right, fx), min(down, fy), max(up, fy)
    return left + right, down + up


@kernel
def nearest_point(x: float, y: float, segments: Floats, discs: Floats) -> tuple[float, float]:
    """Return the point of a boundary that is nearest to a point [m].

    Args:
        x: The point [m].
        y: The point [m].
        segments: x0, y0, x1, y1 [m], shape ``(n_segments, 4)``.
        discs: x, y, radius [m], shape ``(n_discs, 3)``.
    """
    best, best_x, best_y = np.inf, x, y
    for i in range(segments.shape[0]):
        cx, cy = foot_on(x, y, segments[i])
        distance = np.sqrt((x - cx) * (x - cx) + (y - cy) * (y - cy))
        if distance < best:
            best, best_x, best_y = distance, cx, cy
    for i in range(discs.shape[0]):
        dx, dy, radius = x - discs[i, 0], y - discs[i, 1], discs[i, 2]
        off = np.sqrt(dx * dx + dy * dy)
        if off > 0.0 and np.abs(off - radius) < best:
            best, share = np.abs(off - radius), radius / off
            best_x, best_y = discs[i, 0] + share * dx, discs[i, 1] + share * dy
    return best_x, best_y


@kernel
def foot_on(x: float, y: float, segment: Floats) -> tuple[float, float]:
    """Return the point of a segment that is nearest to a point [m]."""
    ax, ay = segment[0], segment[1]
    dx, dy = segment[2] - ax, segment[3] - ay
    length2 = dx * dx + dy * dy
    if length2 < 1e-12:
        return ax, ay
    share = max(0.0, min(1.0, ((x - ax) * dx + (y - ay) * dy) / length2))
    return ax + share * dx, ay + share * dy


@kernel
def length_of(x: float, y: float, by_hypot: bool) -> float:
    """Return the length of a vector; the way it is rounded decides which way bodies at rest are pushed."""
    return float(np.hypot(x, y) if by_hypot else np.sqrt(x * x + y * y))
