"""The predictor: what a robot will see when its next command acts, some time after it has measured.

The pose is rolled forward through the commands that are still under way, and the points of the scan are turned into
that pose. What moves by itself is seen where it was.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.robot.inputs import scanner_of
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.episodes.prediction import steers
from irsim_gym.tasks.terms.graph import RobotValues, Value, between_edges


def pending_spans(seconds: float, period: float) -> list[float]:
    """Return for how long each command under way still acts [s], the oldest first."""
    count = math.ceil(seconds / period - 1e-9)
    return [seconds - (count - 1) * period, *[period] * (count - 1)] if count > 0 else []


def predicted(
    robot: RobotValues, episodes: Episodes, spans: Sequence[float], agent: int = 0
) -> tuple[RobotValues, Value]:
    """Return what a robot will know in some time, and the commands under way, ``(batch, n, n_components)``.

    They are the state ``pending``, which the caller keeps: without the oldest one, with the new one at the end.

    Args:
        spans: For how long each command under way still acts [s], the oldest first.
    """
    graph, model, b = robot.graph, episodes.simulation.model, episodes.task.agents[agent]
    size = int(episodes.action_sizes[agent])
    pending, limits = graph.state("pending", np.zeros((len(spans), size))), model.acceleration_limit[0, b, :size]
    velocities = [pending.columns(k, k + 1) for k in range(len(spans))]
    for k, span in enumerate(spans) if np.isfinite(limits).any() else ():
        before = velocities[k - 1] if k > 0 else robot.velocity.spread(1)
        velocities[k] = before + (velocities[k] - before).between(-limits * span, limits * span)
    ahead, left, rate = _twist(graph.join(velocities), episodes, b)
    spent = np.array(spans)[:, None]
    turn, middle = rate.times(spent), rate.times(spent * (np.tri(len(spans)).T - 0.5 * np.eye(len(spans))))
    cosine, sine = middle.op("Cos"), middle.op("Sin")
    x, y = (ahead * cosine - left * sine).times(spent), (ahead * sine + left * cosine).times(spent)
    heading = robot.pose.columns(2, 3)
    cosine, sine = heading.op("Cos"), heading.op("Sin")
    pose = robot.pose + graph.join([cosine * x - sine * y, sine * x + cosine * y, turn])
    ranges = _ranges_from(robot, episodes, (x, y, turn), agent)
    return replace(robot, ranges=ranges, pose=pose, velocity=velocities[-1].op("Flatten")), pending


def _twist(velocities: Value, episodes: Episodes, body: int) -> tuple[Value, Value, Value]:
    """Return velocities ``(batch, n, n_components)`` in the body frame: ahead, to the left, and the turn rate."""
    drive, first, second = episodes.simulation.model.drive[body], velocities.part(0), velocities.part(1)
    nothing = first * 0.0
    if drive == DIFFERENTIAL:
        return first, nothing, second
    if drive == ACKERMANN:
        if steers(episodes.simulation, body):
            slope = second.op("Sin") / second.op("Cos")
            return first, nothing, first * slope / float(episodes.simulation.model.wheelbase[body])
        return first, nothing, first.equals(0.0).where(nothing, second)  # a car that stands cannot turn
    return first, second, velocities.part(2) if drive == OMNI_ANGULAR else nothing


def _ranges_from(robot: RobotValues, episodes: Episodes, moved: tuple[Value, Value, Value], agent: int) -> Value:
    """Return the scan as it would be after a move, given in the body frame [m, m, rad]."""
    scanner = scanner_of(episodes, agent)
    if scanner is None or len(scanner[2]) < 2:
        return robot.ranges
    options, _, angles = scanner
    mount_x, mount_y, mount_turn = options.offset
    far = options.range_max
    x, y, turn = (value.cast(np.float32) for value in moved)
    at_x, at_y = (
        robot.ranges * function(angles + mount_turn).astype(np.float32) + mount - shift
        for function, mount, shift in ((np.cos, mount_x, x), (np.sin, mount_y, y))
    )
    cosine, sine = turn.op("Cos"), turn.op("Sin")
    ahead, left = cosine * at_x + sine * at_y - mount_x, cosine * at_y - sine * at_x - mount_y
    length = (robot.ranges < far).where((ahead * ahead + left * left).op("Sqrt"), far)
    within = between_edges(ahead, left, _edges(angles) + mount_turn)
    nearest = within.where(length.spread(1), np.inf).smallest(2)
    found, order = nearest.between(options.range_min, far), np.arange(len(angles))
    # A beam between two points that have moved apart reads what its neighbours do.
    beside = found.take(np.maximum(order - 1, 0)).least(found.take(np.minimum(order + 1, len(angles) - 1)))
    return (nearest < np.inf).where(found, beside)


def _edges(angles: Floats) -> Floats:
    """Return the angles [rad] between which beams of even steps look, ``(n_beams + 1,)``."""
    step = (angles[-1] - angles[0]) / (len(angles) - 1)
    edges: Floats = angles[0] + step * (np.arange(len(angles) + 1) - 0.5)
    return edges
