"""IR-SIM's functions about angles, frames and points. Arguments are flat or columns, results are columns."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.population.body_info import half_planes
from irsim_gym.simulator.readings.shapely_outline import moved
from irsim_gym.simulator.world.outline import chain

TURN = 2.0 * math.pi


def _finite(angle: ArrayLike) -> Floats:
    """Return angles with 0 for those that are not finite, as IR-SIM reads them."""
    angles = np.asarray(angle, np.float64)
    return np.where(np.isfinite(angles), angles, 0.0)


def _like(angle: Floats) -> Any:
    """Return a number for an array without axes."""
    return angle if angle.ndim else float(angle)


def WrapToPi(rad: ArrayLike, positive: bool = False) -> Any:  # noqa: N802
    """Return an angle, or an array of them, in [-pi, pi) [rad]; 0 for one that is not finite.

    Args:
        rad: The angle [rad].
        positive: Without its sign.
    """
    wrapped = (_finite(rad) + math.pi) % TURN - math.pi
    return _like(np.abs(wrapped) if positive else wrapped)


def WrapTo2Pi(rad: ArrayLike) -> Any:  # noqa: N802
    """Return an angle, or an array of them, in [0, 2 pi) [rad]; 0 for one that is not finite.

    Args:
        rad: The angle [rad].
    """
    return _like(_finite(rad) % TURN)


def ClipTo2Pi(rad: ArrayLike) -> Any:  # noqa: N802
    """Return the width of a sweep, or an array of them, within [0, 2 pi] [rad]; 0 for one that is not finite.

    Args:
        rad: The width [rad].
    """
    return _like(np.clip(_finite(rad), 0.0, TURN))


def WrapToRegion(rad: float, range: Sequence[float]) -> float:  # noqa: N802
    """Return an angle in an interval that is a full turn wide [rad].

    Args:
        rad: The angle [rad].
        range: Both ends [rad].

    Raises:
        ValueError: The interval is not a full turn wide.
    """
    low, high = range
    if not math.isclose(high - low, TURN):
        raise ValueError(f"range is a full turn, such as [-pi, pi], got {range!r}")
    return rad if low <= rad <= high else low + (rad - low) % TURN


def dist_hypot(x1: float, y1: float, x2: float, y2: float) -> float:
    """Return the distance between two points [m].

    Args:
        x1, y1: One of them [m].
        x2, y2: The other one [m].
    """
    return math.hypot(x2 - x1, y2 - y1)


def distance(point1: ArrayLike, point2: ArrayLike) -> float:
    """Return the distance between two points [m].

    Args:
        point1, point2: x, y and perhaps more [m], flat or columns.
    """
    return relative_position(point1, point2)[0]


def relative_position(position1: ArrayLike, position2: ArrayLike, topi: bool = True) -> tuple[float, float]:
    """Return how far [m] and in which direction [rad] one point is from another.

    Args:
        position1: From where: x, y and perhaps more [m], flat or a column.
        position2: To where.
        topi: Straight back is -pi, not pi.
    """
    x, y = as_row(position2)[:2] - as_row(position1)[:2]
    bearing = math.atan2(y, x)
    return math.hypot(x, y), WrapToPi(bearing) if topi else bearing


def as_row(values: ArrayLike) -> Floats:
    """Return numbers as a flat array, shape ``(n,)``."""
    return np.asarray(values, np.float64).reshape(-1)


def _column(*values: float) -> Floats:
    return np.array(values).reshape(-1, 1)


def get_transform(state: ArrayLike) -> tuple[Floats, Floats]:
    """Return position [m], shape ``(2, 1)``, and rotation, shape ``(2, 2)``, of a state.

    Args:
        state: x, y and perhaps the heading [m, m, rad].
    """
    x, y, heading = np.append(as_row(state), 0.0)[:3]
    cosine, sine = math.cos(heading), math.sin(heading)
    return _column(x, y), np.array([[cosine, -sine], [sine, cosine]])


def transform_point_with_state(point: ArrayLike, state: ArrayLike) -> Floats:
    """Return a pose in the frame of a state as a pose in the world [m, m, rad], shape ``(3, 1)``.

    Args:
        point: x, y, heading in the frame [m, m, rad].
        state: x, y, heading of the frame [m, m, rad].
    """
    place, rotation = get_transform(state)
    x, y = (rotation @ as_row(point)[:2, None] + place)[:, 0]
    return _column(x, y, WrapToPi(as_row(point)[2] + as_row(state)[2]))


def get_affine_transform(state: ArrayLike) -> list[float]:
    """Return what ``shapely.affinity.affine_transform`` takes for a state.

    Args:
        state: x, y and perhaps the heading [m, m, rad].
    """
    place, rotation = get_transform(state)
    return [*map(float, rotation.ravel()), *map(float, place.ravel())]


def geometry_transform(geometry: Any, state: ArrayLike) -> Any:
    """Return a shapely geometry turned by the heading and moved to the place of a state.

    Args:
        geometry: The geometry.
        state: x, y and perhaps the heading [m, m, rad].
    """
    return moved(geometry, *map(float, np.append(as_row(state), 0.0)[:3]))


def vertices_transform(vertices: Floats | None, state: ArrayLike | None) -> Floats | None:
    """Return points in the frame of a state as points of the world [m], shape ``(2, n)``; None without both.

    Args:
        vertices: The points [m], shape ``(2, n)``.
        state: x, y and perhaps the heading [m, m, rad].
    """
    if vertices is None or state is None:
        return None
    place, rotation = get_transform(state)
    return np.asarray(rotation @ np.asarray(vertices) + place)


def vel_omni2world(state_ori: float, vel_body: ArrayLike) -> Floats:
    """Return a velocity of the body as vx, vy of the world [m/s], shape ``(2, 1)``.

    Args:
        state_ori: Heading of the body [rad].
        vel_body: Velocity ahead and to the left [m/s].
    """
    return np.asarray(get_transform([0.0, 0.0, state_ori])[1] @ as_row(vel_body)[:2, None])


def vel_world2omni(state_ori: float, vel_world: ArrayLike) -> Floats:
    """Return a velocity of the world as one ahead and to the left [m/s], shape ``(2, 1)``.

    Args:
        state_ori: Heading of the body [rad].
        vel_world: vx, vy [m/s].
    """
    return vel_omni2world(-state_ori, vel_world)


def vel_diff2world(state_ori: float, vel_diff: ArrayLike) -> Floats:
    """Return the command of a differential drive as vx, vy of the world [m/s], shape ``(2, 1)``.

    Args:
        state_ori: Heading of the body [rad].
        vel_diff: Linear and angular velocity [m/s, rad/s].
    """
    return vel_omni2world(state_ori, [np.append(as_row(vel_diff), 0.0)[0], 0.0])


def vel_world2diff(
    state_ori: float,
    vel_omni: ArrayLike,
    w_max: float = 1.5,
    guarantee_time: float = 0.2,
    tolerance: float = 0.1,
    mini_speed: float = 0.02,
) -> Floats:
    """Return the command of a differential drive that follows a velocity vx, vy of the world, shape ``(2, 1)``.

    Args:
        state_ori: Heading of the robot [rad].
        vel_omni: The velocity [m/s].
        w_max: Greatest turn rate [rad/s].
        guarantee_time: Time in which the robot turns to face the velocity [s].
        tolerance: It does not turn for a smaller angle [rad].
        mini_speed: It stands still for velocities up to this [m/s].
    """
    speed, bearing = relative_position([0.0, 0.0], vel_omni)
    if speed <= mini_speed:
        return _column(0.0, 0.0)
    error = WrapToPi(bearing - state_ori)
    rate = 0.0 if abs(error) < tolerance else min(max(error / guarantee_time, -w_max), w_max)
    return _column(max(speed * math.cos(error), 0.0), rate)


omni_to_diff, diff_to_omni = vel_world2diff, vel_diff2world


def cross_product(o: Sequence[float], a: Sequence[float], b: Sequence[float]) -> float:
    """Return the cross product of two vectors [m2].

    Args:
        o: Where both begin: x, y [m].
        a, b: Where they end [m].
    """
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])


def is_convex_and_ordered(points: Floats) -> tuple[bool, str | None]:
    """Return whether a polygon is convex, and the order of its corners: ``CCW``, ``CW``, or None if it is not.

    Args:
        points: Its corners [m], shape ``(2, n)``.
    """
    corners = np.asarray(points, np.float64).T
    if len(corners) < 3:
        return False, None
    following = zip(corners, np.roll(corners, -1, axis=0), np.roll(corners, -2, axis=0), strict=True)
    turns = [cross_product(*three) for three in following]
    if max(turns) > 0.0 > min(turns):
        return False, None
    return True, "CCW" if max(turns) > 0.0 else "CW"


def gen_inequal_from_vertex(vertex: Floats) -> tuple[Floats | None, Floats | None]:
    """Return G, shape ``(n, 2)``, and h, shape ``(n, 1)``, of a convex polygon: its points p have G p <= h.

    Both are None for a polygon that is not convex.

    Args:
        vertex: Its corners [m], shape ``(2, n)``.
    """
    corners = np.asarray(vertex, np.float64).T
    corners = corners[::-1] if is_convex_and_ordered(vertex)[1] == "CW" else corners
    normals, offsets, _ = half_planes(chain(corners, closed=True), np.zeros((0, 3)), solid=True)
    return normals, None if offsets is None else offsets[:, None]


def to_numpy(
    data: ArrayLike | None, default: Floats | None = None, expected_shape: tuple[int, ...] | None = None
) -> Any:
    """Return numbers as an array, flat ones as a column.

    Args:
        data: The numbers; None for the default.
        default: What stands for None, of any shape.
        expected_shape: Shape of the result.
    """
    chosen = default if data is None else np.asarray(data)
    if chosen is None:
        return None
    chosen = chosen.reshape(-1, 1) if chosen.ndim == 1 and data is not None else chosen
    return chosen if expected_shape is None else chosen.reshape(expected_shape)


def is_2d_list(data: object) -> bool:
    """Return whether this is a sequence of lists or tuples, and no array."""
    return isinstance(data, Sequence) and isinstance(next(iter(data), None), list | tuple)
