"""What can be read of one body of one world, under one vocabulary for scripts, behaviours and wrappers."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base import families
from irsim_gym.base.errors import UnknownNameError
from irsim_gym.simulator.world.arrays import A
from irsim_gym.simulator.world.names import Floats, Group, Model, State, WorldContext, find_sensor
from irsim_gym.simulator.world.outline import corner_points, extent, outline_rows, placed

T = TypeVar("T")


class SpecField(Generic[T]):
    """A field of the body's specification, readable under the same name.

    Args:
        meaning: Its documentation.
    """

    def __init__(self, meaning: str) -> None:
        self.__doc__ = meaning
        self._name = ""

    def __set_name__(self, owner: type[Any], name: str) -> None:
        self._name = name

    def __get__(self, body: BodyReadings | None, owner: type[Any] | None = None) -> T:
        return self if body is None else getattr(body.spec, self._name)  # type: ignore[return-value]


class BodyReadings(ABC):
    """One body of one world. It stores no reading, so it always shows the present state.

    Subclasses say which body it is and how arrays are returned: as copies, read-only copies, or columns ``(n, 1)``.
    """

    __slots__ = ()

    @property
    @abstractmethod
    def _model(self) -> Model:
        """Constants of the episode."""

    @property
    @abstractmethod
    def _now(self) -> State:
        """State of all worlds."""

    @property
    @abstractmethod
    def _w(self) -> int:
        """Index of the world."""

    @property
    @abstractmethod
    def _b(self) -> int:
        """Index of the body."""

    @property
    @abstractmethod
    def _context(self) -> WorldContext:
        """Specifications, sensors and fields of view."""

    @property
    @abstractmethod
    def _columns(self) -> bool:
        """Vectors have shape ``(n, 1)`` and points ``(2, n)``."""

    @property
    @abstractmethod
    def _measures(self) -> tuple[Floats, Floats]:
        """Arrays of radii and centroids as the model has them, valid for this body."""

    @abstractmethod
    def _array(self, values: Floats) -> Floats:
        """Return a copy of an array that is the same with and without columns."""

    @abstractmethod
    def _vector(self, values: Floats) -> Floats:
        """Return a copy of a vector, as a column if columns are asked for."""

    @abstractmethod
    def _reading(self, values: A) -> A:
        """Return an array of a sensor's report, which is a copy already."""

    @abstractmethod
    def _body(self, index: int) -> Self:
        """Return the readings of another body of the same world."""

    @property
    @abstractmethod
    def spec(self) -> Any:
        """What the file says about it."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Its name."""

    @property
    @abstractmethod
    def id(self) -> int:
        """Its number."""

    @property
    @abstractmethod
    def velocity(self) -> Floats:
        """Velocity in the drive's coordinates [m/s or rad/s], shape ``(2,)`` or ``(3,)``."""

    role = SpecField[str]("``robot`` or ``obstacle``.")
    group = SpecField[int]("Number of its group.")
    group_name = SpecField[str]("Name of its group.")
    static = SpecField[bool]("It never moves.")
    color = SpecField[str]("Its colour.")
    description = SpecField[str | None]("Image that it is drawn with, or None.")
    arrive_mode = SpecField[str]("``position`` or ``state``.")
    angle_range = SpecField[tuple[float, float]]("Interval that headings wrap into [rad].")
    fov = SpecField[float | None]("Width of its field of view [rad], None without one.")
    fov_radius = SpecField[float | None]("Depth of its field of view [m], None without one.")
    sensors = SpecField[tuple[Any, ...]]("Options of its sensors, in the order of the file; see ``scan``.")

    @property
    def pose(self) -> Floats:
        """Position and heading: x, y [m], heading [rad], shape ``(3,)``."""
        return self._array(self._now.pose[self._w, self._b])

    @property
    def state(self) -> Floats:
        """x, y, heading [m, m, rad], shape ``(3,)``; with the steering angle [rad] of an ``acker`` drive ``(4,)``."""
        size = getattr(self.spec.kinematics, "state_size", 3)
        return self._vector(np.append(self._now.pose[self._w, self._b], self.steering)[:size])

    @property
    def position(self) -> Floats:
        """x, y [m], shape ``(2,)``."""
        return self._vector(self._now.pose[self._w, self._b, :2])

    @property
    def orientation(self) -> float:
        """Heading of its own frame [rad]."""
        return float(self._now.pose[self._w, self._b, 2])

    @property
    def steering(self) -> float:
        """Steering angle of a car [rad]."""
        return float(self._now.steering[self._w, self._b])

    @property
    def twist(self) -> Floats:
        """Velocity in the world frame: vx, vy [m/s], turn rate [rad/s], shape ``(3,)``."""
        return self._vector(self._now.twist[self._w, self._b])

    @property
    def goal(self) -> Floats | None:
        """The next goal: x, y [m], heading [rad], shape ``(3,)``; None without one.

        The heading is NaN if the goal has none. In a world with ``columns``, it is left out then.
        """
        if not self._model.has_goal[self._b]:
            return None
        goal = self._now.goal[self._w, self._b]
        return self._vector(goal[:2] if self._columns and np.isnan(goal[2]) else goal)

    @property
    def goals(self) -> Floats:
        """The goals that are left in this round, the next one first, shape ``(n, 3)``."""
        w, b = self._w, self._b
        if not self._model.has_goal[b]:
            return self._array(np.zeros((0, 3)))
        left = slice(int(self._now.waypoint[w, b]), int(self._now.waypoint_end[w, b]))
        return self._array(self._model.waypoints[w, b, left])

    @property
    def goal_threshold(self) -> float:
        """Distance under which a goal is reached [m]."""
        return float(self._of(self._model.goal_threshold))

    @property
    def arrived(self) -> bool:
        """It is at its last goal."""
        return bool(self._now.arrived[self._w, self._b])

    @property
    def collided(self) -> bool:
        """It touches another body."""
        return bool(self._now.collided[self._w, self._b])

    @property
    def stopped(self) -> bool:
        """A collision holds it in place."""
        return bool(self._now.stopped[self._w, self._b])

    has_arrived, has_collided, is_stopped = arrived, collided, stopped

    def done(self) -> bool:
        """Return whether it has arrived or a collision holds it in place."""
        return self.arrived or self.stopped

    @property
    def hit(self) -> Self | None:
        """The body that it touches (the first one), or None."""
        other = int(self._now.hit[self._w, self._b])
        return None if other < 0 else self._body(other)

    @property
    def is_movable(self) -> bool:
        """False for a body that never moves."""
        return bool(self._model.movable[self._b])

    @property
    def unobstructed(self) -> bool:
        """Collisions and sensors ignore it, behaviours do not."""
        return bool(self._model.unobstructed[self._b])

    is_unobstructed = unobstructed

    @property
    def shape(self) -> str:
        """Name of its shape; ``map`` for the obstacle map."""
        is_map = int(self._model.map_frame[0].body) == self._b
        return "map" if is_map else families.FOOTPRINTS.name_of(type(self.spec.shape))

    @property
    def kinematics(self) -> str | None:
        """Name of its drive, None without one."""
        drive = self.spec.kinematics
        return None if drive is None else families.KINEMATICS.name_of(type(drive))

    @property
    def radius(self) -> float:
        """Radius of the least circle around it [m]."""
        return float(self._of(self._measures[0]))

    @property
    def center(self) -> Floats:
        """Centre of its area in the world frame: x, y [m], shape ``(2,)``."""
        return self._array(np.array(self._middle()))

    def _middle(self) -> tuple[float, float]:
        # The centroid is given in the body frame: turn it by the heading, then shift it.
        x, y, heading = map(float, self._now.pose[self._w, self._b])
        ahead, left = map(float, self._of(self._measures[1]))
        cosine, sine = math.cos(heading), math.sin(heading)
        return x + cosine * ahead - sine * left, y + sine * ahead + cosine * left

    @property
    def length(self) -> float:
        """Size along its own x axis [m]."""
        return extent(*self._outline(local=True))[0]

    @property
    def width(self) -> float:
        """Size along its own y axis [m]."""
        return extent(*self._outline(local=True))[1]

    @property
    def segments(self) -> Floats:
        """Straight parts of the outline in the world frame: x0, y0, x1, y1 [m], shape ``(n, 4)``."""
        return self._array(self._outline()[0])

    @property
    def discs(self) -> Floats:
        """Round parts of the outline in the world frame: x, y, radius [m], shape ``(n, 3)``."""
        return self._array(self._outline()[1])

    @property
    def vertices(self) -> Floats:
        """Corners in the world frame [m], shape ``(n, 2)``; empty for a circle.

        As columns they are ``(2, n)``, and a circle has 64.
        """
        return self._corners(*self._outline(), self.orientation)

    @property
    def goal_vertices(self) -> Floats | None:
        """``vertices`` at its next goal, likewise of shape ``(n, 2)``; None without a goal.

        If the goal has no heading, the body keeps its own.
        """
        if not self._model.has_goal[self._b]:
            return None
        x, y, heading = map(float, self._now.goal[self._w, self._b])
        heading = self.orientation if math.isnan(heading) else heading
        return self._corners(*placed(*self._outline(local=True), (x, y, heading)), heading)

    def _outline(self, *, local: bool = False) -> tuple[Floats, Floats]:
        return outline_rows(self._model, self._now, self._w, self._b, local=local)

    def _corners(self, segments: Floats, discs: Floats, heading: float) -> Floats:
        corners = corner_points(segments, discs, heading, rounds=self._columns)
        return self._array(corners.T if self._columns else corners)

    @property
    def velocity_min(self) -> Floats:
        """Least velocities in the drive's coordinates [m/s or rad/s], shape ``(3,)``; unused numbers are 0."""
        return self._array(self._of(self._model.velocity_min))

    @property
    def velocity_max(self) -> Floats:
        """Greatest velocities in the drive's coordinates [m/s or rad/s], shape ``(3,)``; unused numbers are 0."""
        return self._array(self._of(self._model.velocity_max))

    @property
    def acceleration_limit(self) -> Floats:
        """Greatest changes of the velocities per second [m/s2 or rad/s2], shape ``(3,)``; may be infinite."""
        return self._array(self._of(self._model.acceleration_limit))

    def scan(self, sensor: int = 0) -> dict[str, Any]:
        """Return the latest scan under IR-SIM's keys: ``angle_min``, ``angle_max``, ``ranges`` and so on.

        Args:
            sensor: Which of its range sensors, in the order of the file.

        Raises:
            UnknownNameError: It has no such sensor.
        """
        group, member = self._range_sensor(sensor)
        report: dict[str, Any] = group.kind.report(group, member, self._w)
        return {key: self._reading(value) if isinstance(value, np.ndarray) else value for key, value in report.items()}

    def scan_points(self, sensor: int = 0) -> Floats | None:
        """Return the points that the latest scan hit, in the sensor's frame [m], shape ``(2, n)``; None without any.

        Raises:
            UnknownNameError: It has no such sensor.
        """
        group, member = self._range_sensor(sensor)
        points: Floats | None = group.kind.points(group, member, self._w)
        return None if points is None else self._reading(points)

    def _range_sensor(self, index: int) -> tuple[Group, int]:
        context = self._context
        sensor = find_sensor(context.bodies, context.sensors, self._b, "ranges", index)
        if sensor is None:
            raise UnknownNameError(f"'{self.name}' has no range sensor number {index}")
        return sensor

    def detected(self) -> list[Self]:
        """Return the bodies in its field of view (``fov``, ``fov_radius``); nothing hides what is behind it.

        Raises:
            UnknownNameError: It has no field of view.
        """
        fov, depth = self.fov, self.fov_radius
        if fov is None or depth is None:
            raise UnknownNameError(f"'{self.name}' has no field of view: give it fov and fov_radius")
        seen = np.zeros(self._model.present.shape, np.bool_)
        world = np.array([self._w], np.int64)
        self._context.detect(world, self._b, fov, depth, self._model, self._now, seen)
        return [self._body(int(b)) for b in np.flatnonzero(seen[self._w])]

    @property
    def time(self) -> float:
        """Time since the start of the episode [s]."""
        return float(self._now.time[self._w])

    @property
    def step_time(self) -> float:
        """Duration of a step [s]."""
        return float(self._model.step_time[0])

    @property
    def _command_size(self) -> int:
        drive = self.spec.kinematics
        return (3 if self.spec.coasts else 2) if drive is None else len(drive.command_names)

    def _of(self, field: NDArray[Any]) -> Any:
        """Return the body's row of a constant that worlds may share."""
        return field[self._w % field.shape[0], self._b]
