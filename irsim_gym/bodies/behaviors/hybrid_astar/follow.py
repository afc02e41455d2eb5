"""Follows a path over poses: the body's place on it, and the command along it, forwards or backwards."""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats, Pose
from irsim_gym.bodies.behaviors.hybrid_astar.moves import SPIN, pose_after
from irsim_gym.bodies.behaviors.hybrid_astar.tables import AHEAD, GEAR, HEADING, LEFT, TURN, PoseWay, X, Y
from irsim_gym.bodies.behaviors.pursuit.commands import STEEPEST, axis_speed, spin
from irsim_gym.bodies.behaviors.pursuit.motion import Command, Moving, executed
from irsim_gym.bodies.behaviors.shared.steering import braked_rate
from irsim_gym.simulator.geometry.angles import wrap_below
from irsim_gym.simulator.world.names import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_WORLD, kernel

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
        two: Second number [m/s, rad/s or rad].
        three: Third number [rad/s].
    """

    pose: Pose
    steering: float
    one: float
    two: float
    three: float


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
    return pose_after((piece[X], piece[Y], piece[HEADING]), (piece[AHEAD], piece[LEFT], piece[TURN]), place.share)


@kernel
def size_of(piece: Floats) -> float:
    """Return the length of a move [m], or the angle of a turn on the spot [rad]."""
    if np.abs(piece[GEAR]) == SPIN:
        return float(np.abs(piece[TURN]))
    return float(np.sqrt(piece[AHEAD] * piece[AHEAD] + piece[LEFT] * piece[LEFT]))


@kernel
def is_last(way: PoseWay, i: int) -> bool:
    """Return whether a body stops at the end of a move: the way ends, or the gear changes."""
    return bool(i + 1 >= way.n_pieces or way.pieces[i + 1, GEAR] != way.pieces[i, GEAR])


@kernel
def place_near(way: PoseWay, place: OnWay, pose: Pose) -> OnWay:
    """Return the place on the way beside a body, from where it was on; it is not beyond the end of the gear."""
    i, share = place.piece, place.share
    for _ in range(ONWARD):
        piece = way.pieces[i]
        size = size_of(piece)
        # Two of Newton's steps towards the nearest point: exact on straight lines, close on arcs.
        for _ in range(2):
            x, y, heading = pose_on(way, OnWay(i, share))
            if np.abs(piece[GEAR]) == SPIN:
                share += wrap_below(pose[2] - heading) / piece[TURN]
            else:
                dx, dy, cosine, sine = pose[0] - x, pose[1] - y, np.cos(heading), np.sin(heading)
                along, across = cosine * dx + sine * dy, cosine * dy - sine * dx
                # The projection onto the move's direction at this place, as a share of its length.
                share += (along * piece[AHEAD] + across * piece[LEFT]) / (size * size)
        if share < 1.0 or is_last(way, i):
            break
        # What goes beyond this move is a share of the next.
        share = min((share - 1.0) * size / size_of(way.pieces[i + 1]), 1.0)
        i += 1
    return OnWay(i, min(max(share, 0.0), 1.0))


@kernel
def offset_from(way: PoseWay, place: OnWay, pose: Pose) -> float:
    """Return how far a body is from a place on the way [m]."""
    x, y, _ = pose_on(way, place)
    return float(np.sqrt((pose[0] - x) * (pose[0] - x) + (pose[1] - y) * (pose[1] - y)))


@kernel
def place_ahead(way: PoseWay, place: OnWay, distance: float) -> OnWay:
    """Return the place on the way that is so much farther on [m or rad], at most the end of the gear."""
    i, share = place.piece, place.share
    while True:
        size = size_of(way.pieces[i])
        # Ends in this move, or at the last one of the gear.
        if share + distance / size <= 1.0 or is_last(way, i):
            return OnWay(i, min(share + distance / size, 1.0))
        distance -= (1.0 - share) * size
        i, share = i + 1, 0.0


@kernel
def left_in_gear(way: PoseWay, place: OnWay) -> float:
    """Return what is left of the way until the gear changes or the way ends [m or rad], as far as is looked."""
    i, total = place.piece, (1.0 - place.share) * size_of(way.pieces[place.piece])
    while total < FAR and not is_last(way, i):
        i += 1
        total += size_of(way.pieces[i])
    return total


@kernel
def command_along(way: PoseWay, place: OnWay, moving: Moving, now: PoseMotion, part: float) -> Command:
    """Return the command that goes on along the way.

    Args:
        way: The way.
        place: Where the body is on it.
        moving: What the body can do.
        now: What it does.
        part: Share of the speed at which it goes; 0 to stop.
    """
    gear = way.pieces[place.piece, GEAR]
    if np.abs(gear) == SPIN:
        axis = 1 if moving.drive == DIFFERENTIAL else 2
        # A turn on the spot is a gear of its own, so what is left of the gear is the angle.
        angle = left_in_gear(way, place) * (1.0 if gear > 0.0 else -1.0)
        rate = part * spin(moving, axis, angle)
        return (0.0, rate, 0.0) if axis == 1 else (0.0, 0.0, rate)
    if moving.drive in (DIFFERENTIAL, ACKERMANN):
        return rolling_command(way, place, moving, now, part)
    return sliding_command(way, place, moving, now, part)


@kernel
def rolling_command(way: PoseWay, place: OnWay, moving: Moving, now: PoseMotion, part: float) -> Command:
    """Return the command of a body that rolls, which brings it back to its way as a critically damped spring would.

    With the offset e from the way to the left, the error a of the heading, the sign s of the gear and the settling
    length l, the curvature is that of the way - e / l^2 - 2 s a / l; then e'' + 2 e' / l + e / l^2 = 0 along the way.
    A car's wheels follow one step later, so it goes by the way that far ahead; it turns them before it sets off.
    """
    step, steers = moving.step, moving.drive == ACKERMANN and not moving.by_rate
    # Backwards, the body moves against its heading: offsets stay as they are, and heading errors act reversed.
    sign = 1.0 if way.pieces[place.piece, GEAR] > 0.0 else -1.0
    x, y, heading = pose_on(way, place)
    cosine, sine = np.cos(heading), np.sin(heading)
    settle = max(SETTLE, SETTLE_STEPS * np.abs(now.one) * step)
    # The offset to the left of the way; clamped, as the spring's law holds near the way only.
    aside = cosine * (now.pose[1] - y) - sine * (now.pose[0] - x)
    aside, error = min(max(aside, -settle), settle), wrap_below(now.pose[2] - heading)
    soon = place_ahead(way, place, np.abs(now.one) * step) if steers else place
    # Curvature of the way: turn per metre, both signed by the gear.
    bend = way.pieces[soon.piece, TURN] / way.pieces[soon.piece, AHEAD]
    bend -= (aside / settle + 2.0 * sign * error) / settle
    top, left = moving.high[0] if sign > 0.0 else -moving.low[0], left_in_gear(way, place)
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
        return sign * speed, angle, 0.0
    # The turn rate has to fit the speed that the acceleration allows.
    speed = executed(moving, 0, sign * speed, now.one)
    rate = bend * speed
    fastest = moving.high[1] if rate > 0.0 else -moving.low[1]
    # Both are reduced, which keeps the curvature.
    if np.abs(rate) > fastest:
        speed, rate = speed * fastest / np.abs(rate), rate * fastest / np.abs(rate)
    # The share of the turn rate that the body reaches in this step; it slows down as much, to stay on the curve.
    turned = executed(moving, 1, rate, now.two) / rate if rate != 0.0 else 1.0
    return speed * min(max(turned, SLOWEST), 1.0), rate, 0.0


@kernel
def sliding_command(way: PoseWay, place: OnWay, moving: Moving, now: PoseMotion, part: float) -> Command:
    """Return the command of a body that moves to any side: towards the place on the way that it reaches in a step."""
    step, (x, y, heading) = moving.step, pose_on(way, place)
    off = np.sqrt((now.pose[0] - x) * (now.pose[0] - x) + (now.pose[1] - y) * (now.pose[1] - y))
    # The way back to the path counts as well.
    left = left_in_gear(way, place) + off
    top = max(moving.high[0], moving.high[1], -moving.low[0], -moving.low[1])
    # It aims as far ahead as it gets in a step, or as it is off, so that it comes back at a slant.
    to_x, to_y, _ = pose_on(way, place_ahead(way, place, max(top * step, off)))
    dx, dy = to_x - now.pose[0], to_y - now.pose[1]
    # The command of the other drives is in the body frame.
    if moving.drive != OMNI_WORLD:
        cosine, sine = np.cos(now.pose[2]), np.sin(now.pose[2])
        dx, dy = cosine * dx + sine * dy, cosine * dy - sine * dx
    distance = np.sqrt(dx * dx + dy * dy)
    if distance == 0.0:
        return 0.0, 0.0, 0.0
    top = min(axis_speed(moving, 0, dx / distance), axis_speed(moving, 1, dy / distance))
    change = min(moving.change[0], moving.change[1])
    speed = min(part * top, braked_rate(top, change, step, left), distance / step)
    turn = part * spin(moving, 2, wrap_below(heading - now.pose[2])) if moving.drive == OMNI_ANGULAR else 0.0
    return speed * dx / distance, speed * dy / distance, turn
