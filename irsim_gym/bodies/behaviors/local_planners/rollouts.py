"""Rollouts of constant commands, and their distances from a scan's points, for local planners.

All coordinates are in the body's present frame: x ahead, y to the left [m].
"""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import BodyOutline, Floats, Record
from irsim_gym.base.kernels.structs import record_type
from irsim_gym.simulator.geometry.overlap import is_round, point_outline_distance
from irsim_gym.simulator.world.names import OMNI_WORLD, Model, State, kernel, row_of
from irsim_gym.simulator.world.twist import Twist, body_twist

LANES = 16
"""Number of poses that are compared with a point at once."""

ROUNDING = 1e-9
"""Relative tolerance of squared distances for rounding."""

POSES = record_type("x y cosine sine near", LANES)
"""Poses [m], and the squared distance of each from the nearest point [m2]."""


class Wheels(NamedTuple):
    """How a body moves with a command.

    Attributes:
        drive: How the command reads, see ``simulator.world.model``.
        by_rate: The second number of an Ackermann drive's command is a turn rate, no steering angle.
        wheelbase: Its axle distance [m].
        cosine: Cosine of its heading.
        sine: Sine of its heading.
    """

    drive: int
    by_rate: bool
    wheelbase: float
    cosine: float
    sine: float


@kernel
def wheels_of(model: Model, state: State, w: int, b: int, by_rate: bool) -> Wheels:
    """Return how body b of world w moves.

    Reads: model (drive, wheelbase), state (pose).
    """
    heading = state.pose[w, b, 2]
    return Wheels(model.drive[b], by_rate, model.wheelbase[b], np.cos(heading), np.sin(heading))


@kernel
def twist_of(wheels: Wheels, first: float, second: float) -> Twist:
    """Return the twist with which a command is executed.

    An Ackermann drive is taken to steer at once, although its wheels follow one step later.
    """
    wheelbase = 0.0 if wheels.by_rate else wheels.wheelbase
    return body_twist((first, second, 0.0), second, wheels.cosine, wheels.sine, wheels.drive, wheelbase)


@kernel
def command_window(model: Model, state: State, w: int, b: int, axis: int) -> tuple[float, float]:
    """Return the least and the greatest value of a number of the command that is executed as it is asked for.

    That is the dynamic window: [max(v_min, v - a t), min(v_max, v + a t)] with the step's duration t.

    Reads: model (acceleration_limit, drive, step_time, velocity_max, velocity_min), state (twist, velocity).

    Args:
        model: What the body can do.
        state: Current state of the worlds.
        w: World.
        b: The body.
        axis: Which number of the command.
    """
    # A plugin's drive gets its command like an omnidirectional one, but `velocity` is in coordinates of its own.
    now = state.twist[w, b, axis] if model.drive[b] == OMNI_WORLD else state.velocity[w, b, axis]
    change = model.acceleration_limit[row_of(model.acceleration_limit, w), b, axis] * model.step_time[0]
    least = max(model.velocity_min[row_of(model.velocity_min, w), b, axis], now - change)
    most = min(model.velocity_max[row_of(model.velocity_max, w), b, axis], now + change)
    # A body that is faster than its limits allow cannot reach them in a step: one value is left.
    return min(least, most), most


@kernel
def place_at(twist: Twist, time: float) -> tuple[float, float, float, float]:
    """Return x, y [m], cosine and sine of the heading after some time with a constant twist: on a circle, or straight.

    Args:
        twist: The twist.
        time: The time [s].
    """
    ahead, left, rate = twist
    turn = rate * time
    cosine, sine = np.cos(turn), np.sin(turn)
    # The chord of a unit-speed arc in the initial frame: sin(turn) / rate ahead and (1 - cos(turn)) / rate to the left.
    along, across = (sine / rate, (1.0 - cosine) / rate) if rate != 0.0 else (time, 0.0)
    return ahead * along - left * across, ahead * across + left * along, cosine, sine


@kernel
def lay_poses(twist: Twist, first: int, step: float, poses: Record) -> None:
    """Write where a twist leads at LANES moments: from ``first + 1`` steps on [s].

    Writes: poses.
    """
    for k in range(LANES):
        poses.x[k], poses.y[k], poses.cosine[k], poses.sine[k] = place_at(twist, (first + k + 1) * step)


@kernel
def find_nearest(points: Floats, n_points: int, poses: Record) -> None:
    """Write the squared distance of each pose from the nearest of some points, infinite without any.

    Writes: poses.

    Args:
        points: x and y [m], shape ``(2, n)``.
        n_points: Number of points.
        poses: The poses; ``near`` is written.
    """
    for k in range(LANES):
        poses.near[k] = np.inf
    for j in range(n_points):
        x, y = points[0, j], points[1, j]
        for k in range(LANES):
            dx, dy = poses.x[k] - x, poses.y[k] - y
            distance2 = dx * dx + dy * dy
            # Selections in place of branches, so that all lanes take one path.
            poses.near[k] = distance2 if distance2 < poses.near[k] else poses.near[k]


@kernel
def gap_at(
    outline: BodyOutline, reach: float, limit: float, points: Floats, n_points: int, poses: Record, k: int
) -> float:
    """Return the distance [m] of an outline at pose k from the nearest point, 0 if it is within; at most ``limit``.

    Args:
        outline: The outline in the body frame.
        reach: Radius about the body's origin that holds it [m].
        limit: Distances above this are reported as this [m].
        points: x and y [m], shape ``(2, n)``.
        n_points: Number of points.
        poses: The poses, with ``near`` as ``find_nearest`` writes it.
        k: Which pose.
    """
    # The outline lies within `reach` of the origin, so points farther away than this cannot be closer than `limit`.
    far = reach + limit
    if poses.near[k] >= far * far:
        return limit
    if is_round(outline):
        return float(max(np.sqrt(poses.near[k]) - reach, 0.0))
    best = limit
    # First the point nearest to the origin alone: the distance found there excludes most others in the second pass.
    for within in (poses.near[k] * (1.0 + ROUNDING), far * far):
        for j in range(n_points):
            dx, dy = points[0, j] - poses.x[k], points[1, j] - poses.y[k]
            distance2 = dx * dx + dy * dy
            if distance2 <= within and distance2 < (reach + best) * (reach + best):
                # The outline is given in the body frame, so the point is turned into it, not the outline out of it.
                x, y = poses.cosine[k] * dx + poses.sine[k] * dy, poses.cosine[k] * dy - poses.sine[k] * dx
                best = min(best, point_outline_distance((x, y), outline))
    return best


@kernel
def spread_over(low: float, high: float, i: int, count: int) -> float:
    """Return the i-th of some values from low to high, evenly spread; mirrored bounds give mirrored values."""
    if count == 1:
        return 0.5 * (low + high)
    return (low * (count - 1 - i) + high * i) / (count - 1)
