"""The moves of a path over poses: arcs and turns on the spot, within a drive's limits."""

import numpy as np

from irsim_gym.bodies.behaviors.local_planners.rollouts import place_at
from irsim_gym.bodies.behaviors.pursuit.commands import STEEPEST
from irsim_gym.bodies.behaviors.pursuit.motion import Moving
from irsim_gym.simulator.world.names import ACKERMANN, DIFFERENTIAL, Pose, Record, Records, kernel, record_type

N_HEADINGS = 72
"""Number of headings that the search tells apart."""
BIN = 2.0 * np.pi / N_HEADINGS
"""Angle between neighbouring headings [rad]."""
MOVE = record_type("ahead turn seconds", gear=np.int64)
"""How far a move leads ahead [m] and turns [rad], evenly along an arc, its duration at full speed [s], and its gear."""
BACKWARD, FORWARD, SPIN = -1, 1, 2
"""Gears; turning on the spot to the right is -SPIN. Between moves of different gears a body stops."""
SPARE = 0.9
"""Share of a body's turning limits that arcs use; the rest is reserved for following them."""
SHARPEST = 0.6
"""Maximum turn of an arc [rad]."""
BENDS = 2
"""Number of arcs to either side."""
MOST_MOVES = 13
"""Maximum number of moves; the last entry is reserved for the move to the goal."""


@kernel
def pose_after(pose: Pose, ahead: float, turn: float, share: float) -> Pose:
    """Return where a share of an arc leads from a pose [m, m, rad]; headings are not wrapped."""
    # A move is the twist that performs it within one unit of time.
    dx, dy, _, _ = place_at((ahead, 0.0, turn), share)
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    return pose[0] + (cosine * dx - sine * dy), pose[1] + (sine * dx + cosine * dy), pose[2] + turn * share


@kernel
def write_move(move: Record, ahead: float, turn: float, seconds: float, gear: int) -> None:
    """Write a move; the arguments are the fields of ``MOVE``."""
    move.ahead, move.turn, move.seconds, move.gear = ahead, turn, seconds, gear


@kernel
def lay_moves(moving: Moving, cell: float, moves: Records) -> int:
    """Write the moves of a body and return how many there are.

    Args:
        moving: What it can do.
        cell: Side of the cells between which its moves lead [m].
        moves: Written: records of type ``MOVE``, shape ``(MOST_MOVES,)``.
    """
    count = add_arcs(moving, BACKWARD, cell, moves, add_arcs(moving, FORWARD, cell, moves, 0))
    if moving.drive == DIFFERENTIAL:
        # Three of the headings that are told apart at once keep searches short.
        angle = 3.0 * BIN
        for side in range(-1, 2, 2):
            rate = moving.high[1] if side > 0 else -moving.low[1]
            if rate > 0.0:
                write_move(moves[count], 0.0, side * angle, angle / rate, side * SPIN)
                count += 1
    return count


@kernel
def bend_of(moving: Moving, gear: int, speed: float, k: int) -> tuple[float, float]:
    """Return the k-th curvature [1/m] of a body, and the turn rate that it may have on it [rad/s]; 0 for none.

    A car that is steered has no limit of its turn rate, but of its curvature; others go slower on their sharpest arcs.
    """
    if moving.drive == ACKERMANN and not moving.by_rate:
        angle = min(max(moving.high[1] if k > 0 else -moving.low[1], 0.0), STEEPEST)
        # Kinematic bicycle model: curvature = tan(angle) / wheelbase.
        return k / BENDS * np.tan(SPARE * angle) / moving.wheelbase, np.inf
    # Driving back turns the sign over: a curvature to the left (k > 0) then takes a turn rate to the right.
    rate = SPARE * max(moving.high[1] if k * gear > 0 else -moving.low[1], 0.0)
    # k times as sharp as the body can turn at full speed; add_arcs gives such an arc the time that it needs.
    return k * rate / speed, rate


@kernel
def add_arcs(moving: Moving, gear: int, cell: float, moves: Records, count: int) -> int:
    """Add the arcs of a gear, which are long enough to end in another cell or with another heading."""
    speed = moving.high[0] if gear == FORWARD else -moving.low[0]
    if speed <= 0.0:
        return count
    sharpest = max(bend_of(moving, gear, speed, BENDS)[0], -bend_of(moving, gear, speed, -BENDS)[0])
    # Two cells lead to another cell in any direction; the sharpest arc must reach another heading as well.
    length = max(2.0 * cell, BIN / sharpest) if sharpest > 0.0 else 2.0 * cell
    for k in range(-BENDS, BENDS + 1):
        bend, rate = bend_of(moving, gear, speed, k)
        if k != 0 and bend == 0.0:
            continue
        # Arcs that would turn too far are widened.
        bend = min(max(bend, -SHARPEST / length), SHARPEST / length)
        turn = gear * length * bend
        seconds = max(length / speed, abs(turn) / rate if bend != 0.0 else 0.0)
        write_move(moves[count], gear * length, turn, seconds, gear)
        count += 1
    return count
