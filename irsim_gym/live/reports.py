"""What a body is and where it is, in IR-SIM's words."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.engine import Simulation
from irsim_gym.engine.measures import measure_into
from irsim_gym.families import FOOTPRINTS, KINEMATICS
from irsim_gym.live.vectors import points, vector

FLATTEST = 1e-9
CORNERS = 64


@dataclass(frozen=True)
class RobotInfo:
    """What a body is. In a world with ``columns`` its flat arrays are columns ``(n, 1)``.

    Attributes:
        id: Its number.
        name: Its name.
        role: ``robot`` or ``obstacle``.
        shape: Name of its shape; ``map`` for the obstacle map.
        kinematics: Name of its drive, None without one.
        color: Its colour.
        static: It never moves.
        goal: x, y, heading [m, m, rad], shape ``(3,)``; None without one.
        vel_min: Least velocities [m/s or rad/s].
        vel_max: Greatest velocities [m/s or rad/s].
        acce: Greatest changes per second [m/s2 or rad/s2].
        angle_range: Interval that headings wrap into [rad].
        goal_threshold: Distance under which a goal is reached [m].
        wheelbase: Axle distance [m], None without one.
        G: Normals of its sides in the body frame, see ``half_planes``.
        h: Their offsets [m].
        cone_type: ``Rpositive``, ``norm2`` or None.
        convex_flag: Its area is convex.
    """

    id: int
    name: str
    role: str
    shape: str
    kinematics: str | None
    color: str
    static: bool
    goal: Floats | None
    vel_min: Floats
    vel_max: Floats
    acce: Floats
    angle_range: tuple[float, float] | Floats
    goal_threshold: float
    wheelbase: float | None
    G: Floats | None
    h: Floats | None
    cone_type: str | None
    convex_flag: bool


@dataclass(frozen=True)
class ObstacleInfo:
    """Where a body is. In a world with ``columns`` its flat arrays are columns ``(n, 1)``, corners ``(2, n)``.

    Attributes:
        center: Its x and y [m], shape ``(2,)``.
        vertex: Corners in the world frame [m], shape ``(n, 2)``; empty for a circle.
        velocity: vx, vy in the world frame [m/s], shape ``(2,)``.
        radius: Radius of the least circle around it [m].
        G: Normals of its sides in the body frame, see ``half_planes``.
        h: Their offsets [m].
        cone_type: ``Rpositive``, ``norm2`` or None.
        convex_flag: Its area is convex.
    """

    center: Floats
    vertex: Floats
    velocity: Floats
    radius: float
    G: Floats | None
    h: Floats | None
    cone_type: str | None
    convex_flag: bool


def robot_info(
    simulation: Simulation, body: int, number: int, goal: Floats | None, *, columns: bool = False
) -> RobotInfo:
    """Return what a body is."""
    spec, model, size = simulation.scenario.bodies[body], simulation.model, command_size(simulation, body)
    wheelbase = float(model.wheelbase[body])
    normals, offsets, cone = half_planes(simulation, body)
    return RobotInfo(
        id=number,
        name=spec.name,
        role=spec.role,
        shape="map" if is_map(simulation, body) else FOOTPRINTS.name_of(type(spec.shape)),
        kinematics=None if spec.kinematics is None else KINEMATICS.name_of(type(spec.kinematics)),
        color=spec.color,
        static=spec.static,
        goal=goal,
        vel_min=vector(model.velocity_min[0, body, :size], columns),
        vel_max=vector(model.velocity_max[0, body, :size], columns),
        acce=vector(model.acceleration_limit[0, body, :size], columns),
        angle_range=vector(np.array(spec.angle_range), True) if columns else spec.angle_range,
        goal_threshold=spec.goal_threshold,
        wheelbase=None if np.isnan(wheelbase) else wheelbase,
        G=normals,
        h=None if offsets is None else vector(offsets, columns),
        cone_type=cone,
        convex_flag=cone is not None,
    )


def obstacle_info(simulation: Simulation, body: int, *, columns: bool = False) -> ObstacleInfo:
    """Return where a body is."""
    normals, offsets, cone = half_planes(simulation, body)
    return ObstacleInfo(
        center=vector(simulation.state.pose[0, body, :2], columns),
        vertex=corners(simulation, body, columns=columns),
        velocity=vector(simulation.state.twist[0, body, :2], columns),
        radius=radius(simulation, body),
        G=normals,
        h=None if offsets is None else vector(offsets, columns),
        cone_type=cone,
        convex_flag=cone is not None,
    )


def is_map(simulation: Simulation, body: int) -> bool:
    """Return whether a body is the obstacle map."""
    return int(simulation.model.map_frame[0].body) == body


def refuse_map(simulation: Simulation, body: int) -> None:
    """Raise an error where a body is to be moved that cannot be.

    Raises:
        ValueError: It is the obstacle map.
    """
    if is_map(simulation, body):
        name = simulation.parts.names[body]
        raise ValueError(f"'{name}' is the obstacle map: its cells stay where they are")


def command_size(simulation: Simulation, body: int) -> int:
    """Return the number of velocities of a body's drive; 2 without one."""
    drive = simulation.scenario.bodies[body].kinematics
    return 2 if drive is None else len(drive.command_names)


def outline_rows(simulation: Simulation, body: int, *, local: bool = False) -> tuple[Floats, Floats]:
    """Return a body's segments (x0, y0, x1, y1) and discs (x, y, radius) [m], in the world's or its own frame."""
    model, state = simulation.model, simulation.state
    segments, discs = (model.local_segments, model.local_discs) if local else (state.segments, state.discs)
    first, disc = int(model.segment_start[body]), int(model.disc_start[body])
    n_segments, n_discs = int(model.segment_count[0, body]), int(model.disc_count[0, body])
    return segments[0, first : first + n_segments], discs[0, disc : disc + n_discs]


def corners(simulation: Simulation, body: int, *, columns: bool = False) -> Floats:
    """Return a body's corners in the world's frame [m].

    Rows ``(n, 2)``, none for a circle; with ``columns`` as IR-SIM has them, ``(2, n)``, and 64 of a circle, clockwise
    from its heading.
    """
    segments, discs = outline_rows(simulation, body)
    if columns and len(discs) == 1 and not len(segments):
        x, y, reach = discs[0]
        turns = simulation.state.pose[0, body, 2] - np.linspace(0.0, 2 * np.pi, CORNERS, endpoint=False)
        return points(np.column_stack([x + reach * np.cos(turns), y + reach * np.sin(turns)]), columns)
    is_open = len(segments) > 0 and not np.array_equal(segments[-1, 2:], segments[0, :2])
    return points(np.vstack([segments[:, :2], segments[-1:, 2:]]) if is_open else segments[:, :2], columns)


def radius(simulation: Simulation, body: int) -> float:
    """Return the radius of the least circle around a body [m]."""
    return _measured(simulation, body)[0]


def centroid(simulation: Simulation, body: int) -> tuple[float, float]:
    """Return x and y of the middle of a body's area [m]."""
    _, ahead, aside = _measured(simulation, body)
    x, y, heading = map(float, simulation.state.pose[0, body])
    cosine, sine = math.cos(heading), math.sin(heading)
    return x + cosine * ahead - sine * aside, y + sine * ahead + cosine * aside


def _measured(simulation: Simulation, body: int) -> tuple[float, float, float]:
    """Return the radius of a body and the middle of its area in its own frame [m]."""
    model = simulation.model
    radii, middles = np.zeros(model.radius.shape), np.zeros(model.centroid.shape)
    measure_into(np.zeros(1, np.int64), np.array([body], np.int64), model, radii, middles)
    return float(radii[0, body]), float(middles[0, body, 0]), float(middles[0, body, 1])


def extent(simulation: Simulation, body: int) -> tuple[float, float]:
    """Return length and width of a body along the axes of its own frame [m]."""
    segments, discs = outline_rows(simulation, body, local=True)
    points = [segments[:, :2], segments[:, 2:], discs[:, :2] - discs[:, 2:], discs[:, :2] + discs[:, 2:]]
    corners = np.vstack(points)
    if not len(corners):
        return 0.0, 0.0
    length, width = corners.max(axis=0) - corners.min(axis=0)
    return float(length), float(width)


def half_planes(
    simulation: Simulation, body: int, *, local: bool = True
) -> tuple[Floats | None, Floats | None, str | None]:
    """Return a convex body as the points p with h - G p in a cone, and the cone's name; by default in its own frame.

    A polygon is ``G p <= h`` (``Rpositive``) with an outward normal, as long as the side, for each side; a circle at c
    with radius r has rows ``[1, 0], [0, 1], [0, 0]`` and ``c, -r`` (``norm2``). G has shape ``(n, 2)``, h ``(n,)``.
    """
    segments, discs = outline_rows(simulation, body, local=local)
    if len(discs) == 1 and not len(segments):
        x, y, reach = discs[0]
        return np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]), np.array([x, y, -reach]), "norm2"
    if len(discs) or len(segments) < 3 or not simulation.model.solid[body]:
        return None, None, None
    starts, sides = segments[:, :2], segments[:, 2:] - segments[:, :2]
    area = float(np.sum(starts[:, 0] * segments[:, 3] - starts[:, 1] * segments[:, 2]))
    normals = np.column_stack([sides[:, 1], -sides[:, 0]]) * np.sign(area)
    offsets = np.sum(normals * starts, axis=1)
    outside = starts @ normals.T - offsets
    is_convex = bool((outside <= FLATTEST * max(abs(area), 1.0)).all())
    return (normals, offsets, "Rpositive") if is_convex else (None, None, None)
