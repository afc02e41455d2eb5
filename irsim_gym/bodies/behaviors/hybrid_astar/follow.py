"""Follows a path over poses: the body's place on it, and the command along it, forwards or backwards."""

from typing import NamedTuple

import numpy as np

from irsim_gym.bodies.behaviors.hybrid_astar.moves import SPIN, pose_after
from irsim_gym.bodies.behaviors.hybrid_astar.queue import pose_of
from irsim_gym.bodies.behaviors.hybrid_astar.tables import PoseWay
from irsim_gym.bodies.behaviors.pursuit.commands import STEEPEST, spin
from irsim_gym.bodies.behaviors.pursuit.motion import Moving, executed
from irsim_gym.bodies.behaviors.shared.steering import braked_rate
from irsim_gym.simulator.geometry.angles import wrap_below
from irsim_gym.simulator.world.names import ACKERMANN, Pose, Record, kernel

SETTLE, SETTLE_STEPS = 0.2, 5.0
"""Distance [m], or number of steps at its speed if that is more, within which a body returns to its path."""
FAR = 4.0
"""Distance up to which the rest of the path is considered [m or rad]."""
ONWARD = 4
"""Maximum number of moves that a body passes in a step."""
SLOWEST = 0.1
"""Minimum share of the speed while a body cannot turn as required yet."""


class PoseMotion(NamedTuple):
    """The motion of a body at one moment.

    Attributes:
        pose: x, y, heading [m, m, rad].
        steering: Steering angle [rad].
        one: First number of what it executes [m/s].
        two: Second number [rad/s or rad].
    """

    pose: Pose
    steering: float
    one: float
    two: float


class OnWay(NamedTuple):
    """A place on a path.

    Attributes:
        piece: Number of the move.
        share: Completed share of the move.
    """

    piece: int
    share: float


@kernel
def pose_on(way: PoseWay, place: OnWay) -> Pose:
    """Return the pose of the way at a place."""
    piece = way.pieces[place.piece]
    return pose_after(pose_of(piece), piece.ahead, piece.turn, place.share)


@kernel
def size_of(piece: Record) -> float:
    """Return the length of a move [m], or the angle of a turn on the spot [rad]."""
    return float(np.abs(piece.turn if np.abs(piece.gear) == SPIN else piece.ahead))


@kernel
def is_last(way: PoseWay, i: int) -> bool:
    """Return whether a body stops at the end of a move: the way ends, or the gear changes."""
    return bool(i + 1 >= way.n_pieces or way.pieces[i + 1].gear != way.pieces[i].gear)


@kernel
def place_near(way: PoseWay, place: OnWay, pose: Pose) -> OnWay:
    """Return the place on the way beside a body, from where it was on; it is not beyond the end of the gear."""
    i, share = place.piece, place.share
    for _ in range(ONWARD):
        piece = way.pieces[i]
        # Two of Newton's steps towards the nearest point: exact on straight lines, close on arcs.
        for _ in range(2):
            x, y, heading = pose_on(way, OnWay(i, share))
            if np.abs(piece.gear) == SPIN:
                share += wrap_below(pose[2] - heading) / piece.turn
            else:
                # The projection onto the heading at this place, as a share of the move's length.
                share += (np.cos(heading) * (pose[0] - x) + np.sin(heading) * (pose[1] - y)) / piece.ahead
        if share < 1.0 or is_last(way, i):
            break
        # What goes beyond this move is a share of the next.
        share = min((share - 1.0) * size_of(piece) / size_of(way.pieces[i + 1]), 1.0)
        i += 1
    return OnWay(i, min(max(share, 0.0), 1.0))


@kernel
def offset_from(way: PoseWay, place: OnWay, pose: Pose) -> float:
    """Return how far a body is from a place on the way [m]."""
    x, y, _ = pose_on(way, place)
    return float(np.sqrt((pose[0] - x) * (pose[0] - x) + (pose[1] - y) * (pose[1] - y)))


@kernel
def left_in_gear(way: PoseWay, place: OnWay) -> float:
    """Return what is left of the way until the gear changes or the way ends [m or rad], as far as is looked."""
    i, total = place.piece, (1.0 - place.share) * size_of(way.pieces[place.piece])
    while total < FAR and not is_last(way, i):
        i += 1
        total += size_of(way.pieces[i])
    return total


@kernel
def command_along(way: PoseWay, place: OnWay, moving: Moving, now: PoseMotion, part: float) -> tuple[float, float]:
    """Return the command that goes on along the way, and back to it as a critically damped spring would.

    With the offset e from the way to the left, the error a of the heading, the sign s of the gear and the settling
    length l, the curvature is that of the way - e / l^2 - 2 s a / l; then e'' + 2 e' / l + e / l^2 = 0 along the way.
    A car's wheels follow one step later, so it goes by the way that far ahead; it turns them before it sets off.

    Args:
        way: The way.
        place: Where the body is on it.
        moving: What the body can do.
        now: What it does.
        part: Share of the speed at which it goes; 0 to stop.
    """
    piece, left = way.pieces[place.piece], left_in_gear(way, place)
    # Backwards, the body moves against its heading: offsets stay as they are, and heading errors act reversed.
    sign = 1.0 if piece.gear > 0 else -1.0
    if np.abs(piece.gear) == SPIN:
        # A turn on the spot is a gear of its own, so what is left of the gear is the angle.
        return 0.0, part * spin(moving, 1, sign * left)
    step, steers = moving.step, moving.drive == ACKERMANN and not moving.by_rate
    x, y, heading = pose_on(way, place)
    settle = max(SETTLE, SETTLE_STEPS * np.abs(now.one) * step)
    # The offset to the left of the way; clamped, as the spring's law holds near the way only.
    aside = np.cos(heading) * (now.pose[1] - y) - np.sin(heading) * (now.pose[0] - x)
    aside, error = min(max(aside, -settle), settle), wrap_below(now.pose[2] - heading)
    if steers and (1.0 - place.share) * size_of(piece) < np.abs(now.one) * step and not is_last(way, place.piece):
        piece = way.pieces[place.piece + 1]
    # Curvature of the way: turn per metre, both signed by the gear.
    bend = piece.turn / piece.ahead - (aside / settle + 2.0 * sign * error) / settle
    top = moving.high[0] if sign > 0.0 else -moving.low[0]
    # Slow enough to stop at the end of the gear, and not past it within this step.
    speed = min(part * top, braked_rate(top, moving.change[0], step, left), left / step)
    if steers:
        low, high = max(moving.low[1], -STEEPEST), min(moving.high[1], STEEPEST)
        # Kinematic bicycle model: tan(angle) = curvature * wheelbase.
        angle = min(max(np.arctan(bend * moving.wheelbase), low), high)
        late, most = np.abs(angle - now.steering), moving.change[1] * step
        # The wheels need more than a step: slower meanwhile, and from rest not at all before they are turned.
        if late > most:
            speed *= max(most / late, SLOWEST) if sign * now.one > 0.0 else 0.0
        return sign * speed, angle
    # The turn rate has to fit the speed that the acceleration allows.
    speed = executed(moving, 0, sign * speed, now.one)
    rate = bend * speed
    fastest = moving.high[1] if rate > 0.0 else -moving.low[1]
    # Both are reduced, which keeps the curvature.
    if np.abs(rate) > fastest:
        speed, rate = speed * fastest / np.abs(rate), rate * fastest / np.abs(rate)
    # The share of the turn rate that the body reaches in this step; it slows down as much, to stay on the curve.
    turned = executed(moving, 1, rate, now.two) / rate if rate != 0.0 else 1.0
    return speed * min(max(turned, SLOWEST), 1.0), rate
