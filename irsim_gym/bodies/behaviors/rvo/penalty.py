"""The sampled velocity with the least penalty, if every sample leads to a collision."""

import numpy as np

from irsim_gym.base.arraytypes import Floats, Records, Vector
from irsim_gym.base.kernels import kernel
from irsim_gym.bodies.behaviors.rvo.free_samples import RvoTables
from irsim_gym.bodies.behaviors.rvo.velocity_obstacles import SLACK, Axis
from irsim_gym.bodies.behaviors.shared.surroundings import Ego

NO_TIME = 1e-4
"""Time to a collision [s] that has begun already."""

NEVER = 1e6
"""Time to a collision with a wall [s] that is not met."""


@kernel
def least_penalty(
    ego: Ego, factor: float, rounds: Records, sides: Floats, along_x: Axis, along_y: Axis, tables: RvoTables
) -> int:
    """Return the sample with the least ``factor / time to the first collision + distance from the wanted velocity``.

    The penalty is that of van den Berg et al. (2008). Samples are tried from the wanted velocity outwards, in the order
    of ``tables.order``; of several equally good samples the first one counts.

    Reads: tables (order, samples).
    """
    samples, order = tables.samples, tables.order
    best, best_cost, least = 0, np.inf, 0.0
    for disc in rounds:
        # Touched already: the first part of the penalty is this for every sample.
        if disc.touch_way == 0.0:
            least = factor * (1.0 / NO_TIME)
    for a in range(along_x.n):
        i = order[0, a]
        dx = samples[0, i] - along_x.wanted
        # All later samples are farther from the wanted velocity, so they cannot cost less.
        if least + np.abs(dx) > best_cost * SLACK:
            break
        for c in range(along_y.n):
            j = order[1, c]
            distance = np.hypot(dx, samples[1, j] - along_y.wanted)
            if least + distance > best_cost * SLACK:
                break
            time = 0.0
            if least == 0.0:
                time = time_to_collision(ego, (samples[0, i], samples[1, j]), rounds, sides)
            cost = factor * (1.0 / (NO_TIME if time == 0.0 else time)) + distance
            # Samples come out of order here; of equal ones, the first in IR-SIM's order (x-major) wins.
            place = i * along_y.n + j
            if cost < best_cost or (cost == best_cost and place < best):
                best, best_cost = place, cost
    return best


@kernel
def time_to_collision(ego: Ego, velocity: Vector, rounds: Records, sides: Floats) -> float:
    """Return the time [s] until a body with a velocity [m/s] collides with a body or wall that it sees.

    A reciprocal body moves as if it took twice the change: relative to a disc it has the velocity 2 v - v_now - u.
    """
    time = np.inf
    for disc in rounds:
        tx, ty = 2.0 * velocity[0] - ego.vx - disc.vx, 2.0 * velocity[1] - ego.vy - disc.vy
        # IR-SIM takes the length of the tangent as the way to the collision; 1e-7 keeps the quotient finite.
        time = min(time, disc.touch_way / (np.sqrt(tx * tx + ty * ty) + 1e-7))
    for side in sides:
        time = min(time, time_to_side(ego, velocity, side))
    return time


@kernel
def time_to_side(ego: Ego, velocity: Vector, side: Floats) -> float:
    """Return the time [s] until a body with a velocity [m/s] meets a segment, or a radius beyond its ends."""
    x, y, vx, vy, r = ego.x, ego.y, velocity[0], velocity[1], ego.radius
    along_x, along_y = side[2] - side[0], side[3] - side[1]
    length = np.sqrt(along_x * along_x + along_y * along_y)
    if length < 1e-12:
        return NEVER
    normal_x, normal_y = -along_y / length, along_x / length
    height = normal_x * (x - side[0]) + normal_y * (y - side[1])
    # A wall has two sides: the normal points to the one that the body is on.
    if height < 0.0:
        normal_x, normal_y, height = -normal_x, -normal_y, -height
    approach = -(normal_x * vx + normal_y * vy)
    if approach <= 1e-7:
        return NEVER
    # When the disc reaches the line; then, whether its centre is beside the segment or within a radius of its ends.
    time = max((height - r) / approach, 0.0)
    share = ((x + vx * time - side[0]) * along_x + (y + vy * time - side[1]) * along_y) / (length * length)
    margin = r / length
    return float(time) if -margin <= share <= 1.0 + margin else NEVER
