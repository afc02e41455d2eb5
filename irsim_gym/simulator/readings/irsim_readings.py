"""IR-SIM's names for the readings of a body, and what its planners ask of one, as IR-SIM computes it."""

import dataclasses
import math
from abc import ABC
from typing import Any, Self

import numpy as np

from irsim_gym.base import families
from irsim_gym.simulator.readings.body_readings import BodyReadings
from irsim_gym.simulator.readings.contact_readings import ContactReadings
from irsim_gym.simulator.readings.sensor_view import SensorView
from irsim_gym.simulator.readings.shapely_outline import moved, shapely_cells, shapely_outline
from irsim_gym.simulator.world.names import OMNI_BODY, OMNI_WORLD, Floats

RVO_MARGIN = 0.1
"""By how much ``radius_extend`` exceeds the radius [m]."""
NEAR_GOAL = 0.1
"""Nearer to the goal than this, the desired velocity is 0 [m]."""


class IrSimReadings(ContactReadings, ABC):
    """One body of one world, also under IR-SIM's names."""

    __slots__ = ()

    arrive = arrive_flag = BodyReadings.arrived
    collision = collision_flag = BodyReadings.collided
    stop_flag = BodyReadings.stopped
    get_fov_detected_objects = BodyReadings.detected

    @property
    def sensors(self) -> tuple[SensorView, ...]:  # type: ignore[override]
        """Its sensors in the order of the file: their options, and for range sensors their latest scans."""
        return tuple(SensorView(self, index) for index in range(len(self.spec.sensors)))

    @property
    def lidar(self) -> SensorView | None:
        """Its first range sensor, None without one."""
        return next((sensor for sensor in self.sensors if sensor.options.reading == "ranges"), None)

    @property
    def geometry(self) -> Any:
        """Its outline in the world frame as a shapely geometry; of a map the boundary of its occupied cells."""
        x, y, heading = map(float, self._now.pose[self._w, self._b])
        return self.original_geometry if self.shape == "map" else moved(self.original_geometry, x, y, heading)

    @property
    def original_geometry(self) -> Any:
        """``geometry`` in its own frame; that of a map is the world."""
        if self.shape == "map":
            squares, frame = self._model.map_squares, self._model.map_frame.item()
            return shapely_cells(squares[self._w % len(squares), 0] == 0, *frame[:4])
        return shapely_outline(*self._outline(local=True), solid=bool(self._model.solid[self._b]))

    @property
    def original_vertices(self) -> Floats:
        """``vertices`` in its own frame [m], shape ``(n, 2)``, or ``(2, n)`` as columns."""
        return self._corners(*self._outline(local=True), 0.0)

    @property
    def original_centroid(self) -> Floats:
        """``centroid`` in its own frame [m], shape ``(2,)``."""
        return self._vector(np.array(self._of(self._measures[1])))

    @property
    def ego_object(self) -> Self:
        """The body itself."""
        return self

    @property
    def beh_config(self) -> dict[str, Any]:
        """Name and options of its behaviour; empty without one."""
        chosen = self.spec.behavior
        if chosen is None:
            return {}
        options = {field.name: getattr(chosen, field.name) for field in dataclasses.fields(chosen)}
        return {"name": families.BEHAVIORS.name_of(type(chosen)), **options}

    @property
    def wander(self) -> bool:
        """Its behaviour draws its goals."""
        return bool(getattr(self.spec.behavior, "wander", False))

    @property
    def loop(self) -> bool:
        """Its behaviour begins its goals again."""
        return bool(getattr(self.spec.behavior, "loop", False))

    @property
    def heading(self) -> float:
        """Direction of travel [rad]: for ``omni`` that of its velocity while it moves, else ``orientation``."""
        vx, vy = self._moving()
        # Omnidirectional drives keep the heading of their frame, so IR-SIM gives the direction of motion instead.
        is_omni = self._model.drive[self._b] in (OMNI_WORLD, OMNI_BODY)
        return math.atan2(vy, vx) if is_omni and (vx or vy) else self.orientation

    @property
    def velocity_xy(self) -> Floats:
        """vx, vy in the world frame [m/s], shape ``(2,)``."""
        return self._vector(self._now.twist[self._w, self._b, :2])

    @property
    def external_objects(self) -> list[Self]:
        """All other bodies."""
        return [self._body(int(b)) for b in np.flatnonzero(self._model.present[self._w]) if b != self._b]

    @property
    def wheelbase(self) -> float | None:
        """Axle distance [m], None without one."""
        distance = float(self._model.wheelbase[self._b])
        return None if math.isnan(distance) else distance

    @property
    def radius_extend(self) -> float:
        """``radius`` plus 0.1 m [m]: radius of the disc that ``rvo`` keeps clear."""
        return self.radius + RVO_MARGIN

    @property
    def centroid(self) -> Floats:
        """Centre of its area in the world frame: x, y [m], shape ``(2,)``."""
        return self._vector(np.array(self._middle()))

    @property
    def vel_min(self) -> Floats:
        """Least velocities in the drive's coordinates [m/s or rad/s], shape ``(2,)`` or ``(3,)``."""
        return self._limit(self._model.velocity_min)

    @property
    def vel_max(self) -> Floats:
        """Greatest velocities in the drive's coordinates [m/s or rad/s], shape ``(2,)`` or ``(3,)``."""
        return self._limit(self._model.velocity_max)

    @property
    def acce(self) -> Floats:
        """Greatest changes per second [m/s2 or rad/s2], shape ``(2,)`` or ``(3,)``; may be infinite."""
        return self._limit(self._model.acceleration_limit)

    def _limit(self, limits: Floats) -> Floats:
        return self._vector(self._of(limits)[: self._command_size])

    def get_vel_range(self) -> tuple[Floats, Floats]:
        """Return least and greatest velocities of the next step [m/s or rad/s], shape ``(2,)`` or ``(3,)`` each.

        They are the limits of velocity, narrowed by those of acceleration.
        """
        change = self._of(self._model.acceleration_limit) * self.step_time
        now, size = self._now.velocity[self._w, self._b], self._command_size
        least = np.maximum(self._of(self._model.velocity_min), now - change)
        greatest = np.minimum(self._of(self._model.velocity_max), now + change)
        return self._vector(least[:size]), self._vector(greatest[:size])

    @property
    def max_speed(self) -> float:
        """Greatest speed over ground [m/s]; 0 without a drive."""
        if self.spec.kinematics is None:
            return 0.0
        ahead, aside = map(float, self._of(self._model.velocity_max)[:2])
        return math.hypot(ahead, aside) if self._moves_sideways else ahead

    @property
    def _moves_sideways(self) -> bool:
        """The first two velocities are along x and y; IR-SIM counts a body without a drive among these."""
        return self.kinematics not in ("diff", "acker")

    def get_desired_omni_vel(self, goal_threshold: float = NEAR_GOAL, normalized: bool = False) -> Floats:
        """Return the velocity straight to the goal at full speed, in the world frame [m/s], shape ``(2,)``.

        Args:
            goal_threshold: Nearer to the goal than this it is 0 [m].
            normalized: Limit it to 1 m/s.
        """
        return self._vector(np.array(self._desired(goal_threshold, normalized)))

    @property
    def desired_omni_vel(self) -> Floats:
        """``get_desired_omni_vel()`` [m/s], shape ``(2,)``."""
        return self.get_desired_omni_vel()

    def _desired(self, goal_threshold: float = NEAR_GOAL, normalized: bool = False) -> tuple[float, float]:
        if not self._model.has_goal[self._b]:
            return 0.0, 0.0
        dx, dy = map(float, (self._now.goal[self._w, self._b] - self._now.pose[self._w, self._b])[:2])
        if math.hypot(dx, dy) <= goal_threshold:
            return 0.0, 0.0
        ahead, aside = map(float, self._of(self._model.velocity_max)[:2])
        bearing = math.atan2(dy, dx)
        # IR-SIM scales both axes by their own limits, so the speed differs between directions.
        vx, vy = ahead * math.cos(bearing), (aside if self._moves_sideways else ahead) * math.sin(bearing)
        speed = max(math.hypot(vx, vy), 1.0) if normalized else 1.0
        return vx / speed, vy / speed

    @property
    def rvo_state(self) -> list[float]:
        """x, y, vx, vy, ``radius_extend``, desired vx and vy, heading [m, m/s, rad]."""
        x, y, heading = map(float, self._now.pose[self._w, self._b])
        return [x, y, *self._moving(), self.radius_extend, *self._desired(), heading]

    @property
    def rvo_neighbor_state(self) -> list[float]:
        """X and y of its centroid, vx, vy, ``radius_extend`` [m, m/s]."""
        return [*self._middle(), *self._moving(), self.radius_extend]

    @property
    def rvo_neighbors(self) -> list[list[float]]:
        """``rvo_neighbor_state`` of all other bodies but the unobstructed ones."""
        return [body.rvo_neighbor_state for body in self.external_objects if not body.unobstructed]

    @property
    def rvo_line_segments(self) -> list[list[float]]:
        """Both ends of each piece of a linestring, x, y, x, y [m]; none for other shapes."""
        return [list(map(float, row)) for row in self._outline()[0]] if self.shape == "linestring" else []

    def _moving(self) -> tuple[float, float]:
        vx, vy = self._now.twist[self._w, self._b, :2]
        return float(vx), float(vy)

    @property
    def state_dim(self) -> int:
        """Number of entries of ``state``."""
        return int(self.state.size)

    @property
    def state_shape(self) -> tuple[int, ...]:
        """Shape of ``state``."""
        return self.state.shape

    @property
    def vel_dim(self) -> int:
        """Number of entries of a command of its drive."""
        return self._command_size

    @property
    def vel_shape(self) -> tuple[int, ...]:
        """Shape of ``vel_max``."""
        return (self._command_size, 1) if self._columns else (self._command_size,)

    @property
    def abbr(self) -> str:
        """The short name that pictures show: first letter of its role, and its number."""
        return f"{self.role[0]}{self.id}"

    @property
    def lidar_offset(self) -> tuple[float, float, float] | None:
        """Mount pose of its first sensor in the body frame [m, m, rad], None without one."""
        return getattr(self.spec.sensors[0], "offset", None) if self.spec.sensors else None

    def get_lidar_scan(self) -> dict[str, Any]:
        """Return the latest scan of its first range sensor; see ``scan``."""
        return self.scan()

    def get_lidar_points(self) -> Floats | None:
        """Return the points that its first range sensor hit [m], shape ``(2, n)``; see ``scan_points``."""
        return self.scan_points()

    def get_lidar_offset(self) -> tuple[float, float, float] | None:
        """Return ``lidar_offset``."""
        return self.lidar_offset

    def fov_detect_object(self, detected_object: BodyReadings) -> bool:
        """Return whether a body is in its field of view; see ``detected``."""
        return detected_object in self.detected()
