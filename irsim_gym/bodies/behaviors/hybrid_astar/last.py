"""The last move, from a pose straight to the goal: an arc, a slide, or a turn on the spot."""

import numpy as np

from irsim_gym.base.arraytypes import Pose, Record, Records
from irsim_gym.base.kernels import kernel
from irsim_gym.bodies.behaviors.hybrid_astar.costs import Aim
from irsim_gym.bodies.behaviors.hybrid_astar.moves import BACKWARD, FORWARD, SLIDE, SPIN
from irsim_gym.simulator.geometry.angles import wrap_below

THERE = 1e-6
"""Distance below which a body is at the position [m]."""


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
    ahead, aside, far2 = cosine * dx + sine * dy, cosine * dy - sine * dx, dx * dx + dy * dy
    turn, is_asked = wrap_below(aim.heading - pose[2]), aim.heading == aim.heading
    if far2 > farthest * farthest:
        return False
    if far2 < THERE * THERE:
        return is_asked and lay_turn(moves, turn, last)
    turns = False
    for k in range(moves.shape[0]):
        turns = turns or abs(moves[k].gear) == SPIN
    # A body that slides has moves of this kind first.
    slides = moves[0].gear == SLIDE
    if slides:
        step = np.sqrt(moves[0].ahead * moves[0].ahead + moves[0].left * moves[0].left)
        last.ahead, last.left, last.turn, last.gear = ahead, aside, 0.0, SLIDE
        last.seconds = np.sqrt(far2) * moves[0].seconds / step
    elif not lay_arc(moves, ahead, aside, last):
        return False
    # A body that turns on the spot puts the heading right after its arrival.
    return bool(turns or not is_asked or abs(wrap_below(turn - last.turn)) < aim.radius)


@kernel
def lay_turn(moves: Records, turn: float, last: Record) -> bool:
    """Return whether a body can turn on the spot by an angle [rad], and write that as a move.

    Writes: last.
    """
    gear = SPIN if turn > 0.0 else -SPIN
    for k in range(moves.shape[0]):
        # No move for no angle. The time is in proportion to the angle.
        if moves[k].gear == gear and turn != 0.0:
            last.ahead, last.left, last.turn, last.gear = 0.0, 0.0, turn, gear
            last.seconds = moves[k].seconds * turn / moves[k].turn
            return True
    return False


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
    last.ahead, last.left, last.turn, last.gear = gear * length, 0.0, gear * length * bend, gear
    last.seconds = length * slowness
    return True
