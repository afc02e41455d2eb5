"""Social forces: the pushes on a body that walks among others.

The push of other bodies is that of Moussaid et al. (2009), the push of walls and the pull to the goal those of Helbing
and Molnar (1995), with IR-SIM's constants and roundings.
"""

from typing import Any

import numpy as np

from irsim_gym.bodies.behaviors.shared import surroundings
from irsim_gym.bodies.behaviors.shared.steering import Turning, to_command
from irsim_gym.bodies.behaviors.social_force import walls
from irsim_gym.simulator.geometry.overlap import point_outline_distance
from irsim_gym.simulator.world.names import Model, State, Vector, kernel, outline_of, row_of

CIRCULAR = 1
"""``interaction: circular``."""

TURN_TOLERANCE, SLOW = 0.02, 0.02
"""How a differential drive follows the planned velocity [rad, m/s]."""


@kernel
def planned_velocity(
    model: Model, state: State, w: int, b: int, options: Any, pref: Vector, extra: Vector, tables: walls.SocialTables
) -> Vector:
    """Return the velocity after one step under all forces [m/s], no faster than ``vmax`` or a drawn speed.

    Reads: model (bucket_frame, centroid, disc_count, disc_start, drawn_speed, heedless, map_disc, map_frame,
        map_squares, movable, present, radius, reach, role, seen_row, segment_count, segment_start, solid, step_time,
        watchers), state (bucket_first, bucket_next, discs, pose, segments, twist), tables (among, by_hypot, discs,
        lines, nearby, nearest, sides).
    Writes: tables (discs, nearby, nearest, sides).

    Args:
        model: Constants of the worlds.
        state: Current state of the worlds.
        w: World.
        b: Body that is pushed.
        options: Parameters of the body.
        pref: Velocity towards the goal; only its direction counts.
        extra: Another force [m/s2].
        tables: Tables for the forces.
    """
    vx, vy = state.twist[w, b, 0], state.twist[w, b, 1]
    fastest = min(options.vmax, model.drawn_speed[row_of(model.drawn_speed, w), b])
    wanted_x, wanted_y = pref
    size = length_of(wanted_x, wanted_y, tables.by_hypot)
    if size > 1e-9:
        wanted_x, wanted_y = fastest * wanted_x / size, fastest * wanted_y / size
    # Helbing and Molnar 1995: the velocity relaxes to the wanted one.
    pull_x, pull_y = (wanted_x - vx) / options.relaxation_time, (wanted_y - vy) / options.relaxation_time
    others_x, others_y, walls_x, walls_y = push_of_bodies(model, state, w, b, options, tables)
    if tables.lines.shape[0] > 0:
        fx, fy = walls.push_of_lines(model, state, w, b, options, tables)
        walls_x, walls_y = walls_x + fx, walls_y + fy
    if surroundings.is_map_seen(model, w, options.target_roles):
        fx, fy = walls.push_of_map(model, state, w, b, options, tables)
        walls_x, walls_y = walls_x + fx, walls_y + fy
    ax = options.force_factor_desired * pull_x + options.force_factor_social * others_x
    ay = options.force_factor_desired * pull_y + options.force_factor_social * others_y
    ax = ax + options.force_factor_obstacle * walls_x + extra[0]
    ay = ay + options.force_factor_obstacle * walls_y + extra[1]
    vx, vy = vx + model.step_time[0] * ax, vy + model.step_time[0] * ay
    speed = length_of(vx, vy, tables.by_hypot)
    if speed > fastest:
        share = fastest / speed
        vx, vy = vx * share, vy * share
    return vx, vy


@kernel
def follow(model: Model, state: State, w: int, b: int, velocity: Vector) -> None:
    """Write the command that follows a velocity within one step, as fast as a differential drive can turn.

    Reads: model (acceleration_limit, drive, step_time, velocity_max), state (pose, velocity).
    Writes: state (command).
    """
    fastest = model.velocity_max[row_of(model.velocity_max, w), b, 1]
    sharpest = model.acceleration_limit[row_of(model.acceleration_limit, w), b, 1]
    # The upper end of the interval that the acceleration allows bounds turns to either side, as in IR-SIM.
    limit = min(fastest, state.velocity[w, b, 1] + sharpest * model.step_time[0])
    turning = Turning(model.step_time[0], TURN_TOLERANCE, SLOW, limit)
    to_command(model.drive[b], state.pose[w, b, 2], velocity[0], velocity[1], turning, state.command[w, b])


@kernel
def push_of_bodies(
    model: Model, state: State, w: int, b: int, options: Any, tables: walls.SocialTables
) -> tuple[float, float, float, float]:
    """Return the push of moving bodies and discs (x, y), and that of standing bodies with sides (x, y).

    The former push up to ``neighbor_threshold`` from centre to centroid; the latter push once for each body, from the
    nearest point of its outline.

    Reads: model (bucket_frame, centroid, disc_count, disc_start, heedless, movable, present, radius, reach, role,
        seen_row, segment_count, segment_start, solid, watchers), state (bucket_first, bucket_next, discs, pose,
        segments, twist), tables (among, by_hypot, nearby).
    Writes: tables (nearby).
    """
    pose, twist, sight, among = state.pose[w], state.twist[w], options.neighbor_threshold, tables.among
    x, y, vx, vy = pose[b, 0], pose[b, 1], twist[b, 0], twist[b, 1]
    r = model.radius[row_of(model.radius, w), b] + surroundings.MARGIN
    # Beyond this, exp(-gap / sigma) is below exp(-FADED).
    reach = walls.FADED * options.sigma_obstacle + r
    most = max(sight, reach)
    others_x, others_y, walls_x, walls_y = 0.0, 0.0, 0.0, 0.0
    for k in range(surroundings.find_around(model, state, w, b, most, tables.nearby)):
        q = tables.nearby[k]
        roles = surroundings.ALL_ROLES if among[q] else options.target_roles
        if surroundings.is_far(model, state, w, b, q, most) or not surroundings.is_seen(model, w, b, q, roles):
            continue
        # Members see each other as discs about their origins, others as look_of says.
        look = surroundings.ROUND if among[q] else surroundings.look_of(model, w, q)
        if look == surroundings.STANDING:
            outline = outline_of(model, state, w, q)
            distance = point_outline_distance((x, y), outline)
            if distance <= reach:
                cx, cy = walls.nearest_point(x, y, outline)
                fx, fy = walls.push_of_wall(x - cx, y - cy, r, options.sigma_obstacle)
                # Inside of the outline, the way out leads towards its nearest point.
                if distance == 0.0:
                    fx, fy = -fx, -fy
                walls_x, walls_y = walls_x + fx, walls_y + fy
        if look == surroundings.ROUND:
            px, py = (pose[q, 0], pose[q, 1]) if among[q] else surroundings.centroid_of(model, state, w, q)
            if (x - px) * (x - px) + (y - py) * (y - py) < sight * sight:
                ux, uy = vx - twist[q, 0], vy - twist[q, 1]
                if options.interaction == CIRCULAR:
                    both = model.radius[row_of(model.radius, w), b] + model.radius[row_of(model.radius, w), q]
                    # Both bodies keep the safety distance.
                    both += 2.0 * options.safety_radius
                    fx, fy = push_of_disc(px - x, py - y, both, options.interaction_range)
                else:
                    fx, fy = push_of_body(px - x, py - y, ux, uy, options, tables.by_hypot)
                others_x, others_y = others_x + fx, others_y + fy
    return others_x, others_y, walls_x, walls_y


@kernel
def push_of_body(dx: float, dy: float, ux: float, uy: float, options: Any, by_hypot: bool) -> Vector:
    """Return the push of another body at (dx, dy) [m] on one whose velocity relative to it is (ux, uy) [m/s].

    After Moussaid et al. (2009): the interaction t points along lambda (v_i - v_j) + e_ij, whose length times gamma is
    the range B. At the distance d and the angle theta between t and the way to the other, the push is
    -exp(-d/B - (n' B theta)^2) along t, and -sign(theta) exp(-d/B - (n B theta)^2) along t's left normal.

    The sideways part changes its sign with the angle between the interaction and the way to the other, at full size.
    Where that angle is 0, as for two bodies at rest, rounding decides on which side a body is pushed.
    """
    # e_ij, the direction to the other body.
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
    # theta, from the interaction to the other body, counter-clockwise.
    angle = np.arctan2(tx * to_y - ty * to_x, tx * to_x + ty * to_y)
    # -d / B, with the distance between the bodies' safety rings.
    fading = -max(distance - 2.0 * options.safety_radius, 0.0) / scale
    braking, turning = options.n_velocity * scale * angle, options.n_angular * scale * angle
    brake = -np.exp(fading - braking * braking)
    turn = -np.sign(angle) * np.exp(fading - turning * turning)
    # (-ty, tx) is the left normal of the interaction.
    return brake * tx - turn * ty, brake * ty + turn * tx


@kernel
def push_of_disc(dx: float, dy: float, both: float, fading: float) -> Vector:
    """Return the push of another disc at (dx, dy) [m] away from it: exp(-gap / fading), with both radii ``both`` [m].

    This is the circular form of Helbing and Molnar (1995). Discs that overlap push each other harder.
    """
    distance = np.sqrt(dx * dx + dy * dy)
    if distance < walls.TOUCHING:
        return 0.0, 0.0
    size = np.exp((both - distance) / fading)
    return -size * dx / distance, -size * dy / distance


@kernel
def length_of(x: float, y: float, by_hypot: bool) -> float:
    """Return the length of a vector; the way it is rounded decides which way bodies at rest are pushed."""
    return float(np.hypot(x, y) if by_hypot else np.sqrt(x * x + y * y))
