"""Properties, place and motion of a body, under IR-SIM's names."""

from __future__ import annotations

from abc import ABC
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.session.vectors import vector
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.readings.irsim_names import advice, missing
from irsim_gym.simulator.readings.irsim_readings import IrSimReadings

OF_BODIES = ("id", "name", "role", "shape", "kinematics", "color", "static", "goal", "goal_threshold", "wheelbase")
"""Properties that a body has under the same name."""
FLATTEST = 1e-9
"""Tolerance for corners outside the half-plane of a side, relative to the area."""


class BodyProperties(ABC):
    """Properties of a body, to which a script may add some of its own."""

    properties: dict[str, Any]

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if name != "properties" and name in self.properties:
                return self.properties[name]
            raise AttributeError(missing("an info", name, advice("body", "script"), dir(self)), name=name, obj=self)

    def add_property(self, name: str, value: object) -> None:
        """Add a property of the script's own, which can then be read as an attribute."""
        self.properties[name] = value


@dataclass(frozen=True)
class RobotInfo(BodyProperties):
    """Properties of a body. In a world with ``columns`` its flat arrays are columns ``(n, 1)``.

    Attributes:
        id: Its number.
        name: Its name.
        role: ``robot`` or ``obstacle``.
        shape: Name of its shape; ``map`` for the obstacle map.
        kinematics: Name of its drive, None without one.
        color: Its colour.
        static: It never moves.
        goal: x, y, heading [m, m, rad], shape ``(3,)``; None without one.
        vel_min: Least velocities [m/s or rad/s], shape ``(2,)`` or ``(3,)``.
        vel_max: Greatest velocities [m/s or rad/s], likewise.
        acce: Greatest changes per second [m/s2 or rad/s2], likewise.
        angle_range: Interval into which headings are wrapped [rad]; with ``columns`` an array of shape ``(2, 1)``.
        goal_threshold: Distance under which a goal is reached [m].
        wheelbase: Axle distance [m], None without one.
        G: Normals of its sides in the body frame, shape ``(n, 2)``; see ``HalfPlanes``.
        h: Their offsets [m], shape ``(n,)``.
        cone_type: ``Rpositive``, ``norm2`` or None.
        convex_flag: Its area is convex.
        properties: Properties that the script added; they stay with the body.
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
    properties: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)


@dataclass(frozen=True)
class ObstacleInfo(BodyProperties):
    """Place and motion of a body. In a world with ``columns`` vectors are columns ``(n, 1)``, corners ``(2, n)``.

    Attributes:
        center: Its x and y [m], shape ``(2,)``.
        vertex: Corners in the world frame [m], shape ``(n, 2)``; empty for a circle.
        velocity: vx, vy in the world frame [m/s], shape ``(2,)``.
        radius: Radius of the least circle around it [m].
        G: Normals of its sides in the body frame, shape ``(n, 2)``; see ``HalfPlanes``.
        h: Their offsets [m], shape ``(n,)``.
        cone_type: ``Rpositive``, ``norm2`` or None.
        convex_flag: Its area is convex.
        properties: Properties that the script added to this record.
    """

    center: Floats
    vertex: Floats
    velocity: Floats
    radius: float
    G: Floats | None
    h: Floats | None
    cone_type: str | None
    convex_flag: bool
    properties: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)


class HalfPlanes(NamedTuple):
    """An area as the points p with ``h - G p`` in a cone, under IR-SIM's names.

    For a convex polygon (``Rpositive``), a point p is inside if ``G p <= h`` in every row. For a circle (``norm2``) at
    c with radius r, the rows of G are ``[1, 0], [0, 1], [0, 0]``, and h is ``[cx, cy, -r]``.

    Attributes:
        G: Normals of its sides, shape ``(n, 2)``; None for an area that is not convex.
        h: Their offsets [m], shape ``(n,)``.
        cone_type: ``Rpositive``, ``norm2`` or None.
        convex_flag: The area is convex.
    """

    G: Floats | None
    h: Floats | None
    cone_type: str | None
    convex_flag: bool


def robot_info(
    body: IrSimReadings,
    limits: tuple[Floats, Floats, Floats],
    half_planes: HalfPlanes,
    properties: dict[str, Any],
    *,
    columns: bool,
) -> RobotInfo:
    """Return what a body is; ``limits`` are its least and greatest velocities, and its greatest changes."""
    least, greatest, changes = limits
    return RobotInfo(
        **{name: getattr(body, name) for name in OF_BODIES},
        vel_min=least,
        vel_max=greatest,
        acce=changes,
        angle_range=vector(np.array(body.angle_range), True) if columns else body.angle_range,
        properties=properties,
        **half_planes._asdict(),
    )


def obstacle_info(body: IrSimReadings, half_planes: HalfPlanes) -> ObstacleInfo:
    """Return where a body is."""
    return ObstacleInfo(body.position, body.vertices, body.velocity_xy, body.radius, *half_planes)


def is_map(simulation: Simulation, body: int) -> bool:
    """Return whether a body is the obstacle map."""
    return int(simulation.model.map_frame[0].body) == body


def refuse_map(simulation: Simulation, body: int) -> None:
    """Raise if a body is the obstacle map, which cannot move.

    Raises:
        ValueError: The body is the obstacle map.
    """
    if is_map(simulation, body):
        name = simulation.parts.names[body]
        raise ValueError(f"'{name}' is the obstacle map: its cells stay where they are")


def half_planes(segments: Floats, discs: Floats, *, solid: bool) -> tuple[Floats | None, Floats | None, str | None]:
    """Return a convex outline as the points p with h - G p in a cone, and the cone's name; None for any other.

    A polygon is ``G p <= h`` (``Rpositive``) with an outward normal, as long as the side, for each side; a circle at c
    with radius r has rows ``[1, 0], [0, 1], [0, 0]`` and ``c, -r`` (``norm2``). G has shape ``(n, 2)``, h ``(n,)``.
    """
    if len(discs) == 1 and not len(segments):
        x, y, reach = discs[0]
        return np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]), np.array([x, y, -reach]), "norm2"
    if len(discs) or len(segments) < 3 or not solid:
        return None, None, None
    starts, sides = segments[:, :2], segments[:, 2:] - segments[:, :2]
    # Twice the area, positive for corners in counter-clockwise order: then (dy, -dx) of a side points outwards.
    area = float(np.sum(starts[:, 0] * segments[:, 3] - starts[:, 1] * segments[:, 2]))
    normals = np.column_stack([sides[:, 1], -sides[:, 0]]) * np.sign(area)
    offsets = np.sum(normals * starts, axis=1)
    outside = starts @ normals.T - offsets
    # Each corner's distance beyond each side, times the side's length: none may lie outside.
    is_convex = bool((outside <= FLATTEST * max(abs(area), 1.0)).all())
    return (normals, offsets, "Rpositive") if is_convex else (None, None, None)
