"""The goal of a search, and the last move, from a pose straight to it: an arc, or a turn on the spot."""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Pose, Record, Records
from irsim_gym.base.kernels import kernel
from irsim_gym.bodies.behaviors.hybrid_astar.moves import BACKWARD, FORWARD, SPIN, write_move
from irsim_gym.simulator.geometry.angles import wrap_below

THERE = 1e-6
"""Distance below which a body is at the position [m]."""


class Aim(NamedTuple):
    """The goal of a search.

    Attributes:
        x: x of the goal [m].
        y: y of the goal [m].
        heading: Heading at the goal [rad]; NaN for any.
        radius: Distance below which the body has arrived; with a heading, metres and radians combined.
    """

    x: float
    y: float
    heading: float
    radius: float


@kernel
def aim_gap(aim: Aim, pose: Pose) -> float:
    """Return how far a pose is from a goal [m], where radians count like metres."""
    dx, dy, turn = pose[0] - aim.x, pose[1] - aim.y, 0.0
    if aim.heading == aim.heading:
        # The heading NaN, which does not equal itself, admits any.
        turn = wrap_below(pose[2] - aim.heading)
    return float(np.sqrt(dx * dx + dy * dy + turn * turn))


@kernel
def lay_last(aim: Aim, moves: Records, farthest: float, pose: Pose, last: Record) -> bool:
    """Return whether a move within the limits of a body leads to the place of the goal, and write it.

    A body at that place turns to the heading of the goal, if it can. One that cannot turn on the spot has to arrive
    with that heading.

    Writes: last.

    Args:
        aim: The goal.
        moves: The moves of the body, which show its limits.
        farthest: From farther away there is none [m].
        pose: Where the body is.
        last: Written.
    """
    dx, dy, cosine, sine = aim.x - pose[0], aim.y - pose[1], np.cos(pose[2]), np.sin(pose[2])
    far2, turn, is_asked = dx * dx + dy * dy, wrap_below(aim.heading - pose[2]), aim.heading == aim.heading
    if far2 > farthest * farthest:
        return False
    # Turns on the spot come last among the moves.
    spins = np.abs(moves[-1].gear) == SPIN
    if far2 < THERE * THERE:
        for move in moves:
            # No move for no angle. The time is in proportion to the angle.
            if spins and move.gear == (SPIN if turn > 0.0 else -SPIN) and turn != 0.0:
                write_move(last, 0.0, turn, move.seconds * turn / move.turn, move.gear)
                return is_asked
        return False
    if not lay_arc(moves, cosine * dx + sine * dy, cosine * dy - sine * dx, last):
        return False
    # A body that turns on the spot puts the heading right after its arrival.
    return bool(spins or not is_asked or np.abs(wrap_below(turn - last.turn)) < aim.radius)


@kernel
def lay_arc(moves: Records, ahead: float, aside: float, last: Record) -> bool:
    """Return whether an arc that begins along the heading leads to a point, and write it.

    Its curvature is 2 y / (x^2 + y^2); it has to lie between those of the moves of its gear.

    Writes: last.

    Args:
        moves: The moves of the body.
        ahead: x of the point in the body's frame [m].
        aside: y of the point [m].
        last: Written.
    """
    gear, low, high, slowness = FORWARD if ahead > 0.0 else BACKWARD, np.inf, -np.inf, 0.0
    # The circle through the point that touches the heading at the origin.
    bend = 2.0 * aside / (ahead * ahead + aside * aside)
    for k in range(moves.shape[0]):
        move = moves[k]
        if move.gear == gear:
            low, high = min(low, move.turn / move.ahead), max(high, move.turn / move.ahead)
            # The time per metre of the slowest move of this gear, so that the last move is no bargain.
            slowness = max(slowness, move.seconds / abs(move.ahead))
    if ahead == 0.0 or not low <= bend <= high:
        return False
    # The chord makes half of the arc's angle with the heading, whose length is angle / curvature.
    half = np.arctan(abs(aside / ahead))
    length = 2.0 * half / abs(bend) if abs(aside) > THERE * abs(ahead) else abs(ahead)
    write_move(last, gear * length, gear * length * bend, length * slowness, gear)
    return True
