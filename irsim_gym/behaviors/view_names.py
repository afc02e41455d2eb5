"""IR-SIM's names for what a body tells, on views: those of ``world.robot`` that have a meaning for a behaviour."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from irsim_gym.arraytypes import Floats
from irsim_gym.behaviors.view_state import StateView
from irsim_gym.world.model import OMNI_BODY, OMNI_WORLD

MARGIN = 0.1
"""By how much ``radius_extend`` exceeds the radius [m]."""
ARRIVED = 0.1
"""Nearer to the goal than this, nothing more is desired [m]."""


class NamedView(StateView):
    """IR-SIM's names, worked out as IR-SIM does."""

    __slots__ = ()

    @property
    def arrived(self) -> bool:
        """It is at its last goal."""
        return bool(self._state.arrived[self._world, self.id])

    @property
    def arrive(self) -> bool:
        """IR-SIM's name for ``arrived``."""
        return self.arrived

    @property
    def arrive_flag(self) -> bool:
        """IR-SIM's name for ``arrived``."""
        return self.arrived

    @property
    def collided(self) -> bool:
        """It touches another body."""
        return bool(self._state.collided[self._world, self.id])

    @property
    def collision(self) -> bool:
        """IR-SIM's name for ``collided``."""
        return self.collided

    @property
    def collision_flag(self) -> bool:
        """IR-SIM's name for ``collided``."""
        return self.collided

    @property
    def stopped(self) -> bool:
        """A collision holds it in place."""
        return bool(self._state.stopped[self._world, self.id])

    @property
    def stop_flag(self) -> bool:
        """IR-SIM's name for ``stopped``."""
        return self.stopped

    def done(self) -> bool:
        """Return whether it has arrived or a collision holds it in place."""
        return self.arrived or self.stopped

    @property
    def position(self) -> Floats:
        """x, y [m], shape ``(2,)``."""
        return self._vector(self._state.pose[self._world, self.id, :2])

    @property
    def orientation(self) -> float:
        """Heading of its own frame [rad]."""
        return float(self._state.pose[self._world, self.id, 2])

    @property
    def heading(self) -> float:
        """Where it drives to [rad]: for ``omni`` the direction of its velocity while it moves, else ``orientation``."""
        vx, vy = self._moving()
        is_sideways = self._model.drive[self.id] in (OMNI_WORLD, OMNI_BODY)
        return math.atan2(vy, vx) if is_sideways and (vx or vy) else self.orientation

    @property
    def velocity_xy(self) -> Floats:
        """vx, vy in the world frame [m/s], shape ``(2,)``."""
        return self._vector(self._state.twist[self._world, self.id, :2])

    def _moving(self) -> tuple[float, float]:
        vx, vy = self._state.twist[self._world, self.id, :2]
        return float(vx), float(vy)

    @property
    def static(self) -> bool:
        """It never moves."""
        return bool(self.spec.static)

    @property
    def group(self) -> int:
        """Number of its group."""
        return int(self.spec.group)

    @property
    def group_name(self) -> str:
        """Name of its group."""
        return str(self.spec.group_name)

    @property
    def color(self) -> str:
        """Its colour."""
        return str(self.spec.color)

    @property
    def description(self) -> str | None:
        """Image that it is drawn with, or None."""
        return None if self.spec.description is None else str(self.spec.description)

    @property
    def arrive_mode(self) -> str:
        """``position`` or ``state``."""
        return str(self.spec.arrive_mode)

    @property
    def angle_range(self) -> tuple[float, float]:
        """Interval that headings wrap into [rad]."""
        low, high = self.spec.angle_range
        return float(low), float(high)

    @property
    def unobstructed(self) -> bool:
        """Collisions and sensors ignore it."""
        return bool(self._model.unobstructed[self.id])

    @property
    def fov(self) -> float | None:
        """Width of its field of view [rad], None without one."""
        return None if self.spec.fov is None else float(self.spec.fov)

    @property
    def fov_radius(self) -> float | None:
        """Depth of its field of view [m], None without one."""
        return None if self.spec.fov_radius is None else float(self.spec.fov_radius)

    @property
    def sensors(self) -> tuple[Any, ...]:
        """Options of its sensors, in the order of the file; ``scan(i)`` is what the i-th range sensor reads."""
        return tuple(self.spec.sensors)

    @property
    def wheelbase(self) -> float | None:
        """Axle distance [m], None without one."""
        distance = float(self._model.wheelbase[self.id])
        return None if math.isnan(distance) else distance

    @property
    def length(self) -> float:
        """Size along its own x axis [m]."""
        return self._extent(0)

    @property
    def width(self) -> float:
        """Size along its own y axis [m]."""
        return self._extent(1)

    def _extent(self, axis: int) -> float:
        segments, discs = self._local_rows()
        low = np.concatenate([segments[:, axis], segments[:, axis + 2], discs[:, axis] - discs[:, 2]])
        high = np.concatenate([segments[:, axis], segments[:, axis + 2], discs[:, axis] + discs[:, 2]])
        return float(high.max() - low.min()) if len(low) else 0.0

    @property
    def vel_min(self) -> Floats:
        """Least velocities in the drive's coordinates [m/s or rad/s], shape ``(2,)`` or ``(3,)``."""
        return self._vector(self._of(self._model.velocity_min)[: self._command_size])

    @property
    def vel_max(self) -> Floats:
        """Greatest velocities in the drive's coordinates [m/s or rad/s], shape ``(2,)`` or ``(3,)``."""
        return self._vector(self._of(self._model.velocity_max)[: self._command_size])

    @property
    def acce(self) -> Floats:
        """Greatest changes per second [m/s2 or rad/s2]; may be infinite."""
        return self._vector(self._of(self._model.acceleration_limit)[: self._command_size])

    def get_vel_range(self) -> tuple[Floats, Floats]:
        """Return least and greatest velocities of the next step [m/s or rad/s], which acceleration limits narrow."""
        window = self._of(self._model.acceleration_limit) * float(self._model.step_time[0])
        now, size = self._state.velocity[self._world, self.id], self._command_size
        least = np.maximum(self._of(self._model.velocity_min), now - window)
        greatest = np.minimum(self._of(self._model.velocity_max), now + window)
        return self._vector(least[:size]), self._vector(greatest[:size])

    @property
    def max_speed(self) -> float:
        """Greatest speed over ground [m/s]; 0 without a drive."""
        if self.spec.kinematics is None:
            return 0.0
        ahead, aside = map(float, self._of(self._model.velocity_max)[:2])
        return math.hypot(ahead, aside) if self._is_sideways else ahead

    @property
    def _is_sideways(self) -> bool:
        """Its first two velocities are those along x and y; so they count for one without a drive."""
        return self.kinematics not in ("diff", "acker")

    @property
    def desired_omni_vel(self) -> Floats:
        """``get_desired_omni_vel()``."""
        return self.get_desired_omni_vel()

    def get_desired_omni_vel(self, goal_threshold: float = ARRIVED, normalized: bool = False) -> Floats:
        """Return the velocity straight to the goal at full speed, in the world frame [m/s], shape ``(2,)``.

        Args:
            goal_threshold: Nearer to the goal than this it is 0 [m].
            normalized: Cut it to 1 m/s.
        """
        return self._vector(np.array(self._desired(goal_threshold, normalized)))

    def _desired(self, goal_threshold: float = ARRIVED, normalized: bool = False) -> tuple[float, float]:
        if not self._model.has_goal[self.id]:
            return 0.0, 0.0
        dx, dy = map(float, (self._state.goal[self._world, self.id] - self._state.pose[self._world, self.id])[:2])
        if math.hypot(dx, dy) <= goal_threshold:
            return 0.0, 0.0
        ahead, aside = map(float, self._of(self._model.velocity_max)[:2])
        bearing = math.atan2(dy, dx)
        vx, vy = ahead * math.cos(bearing), (aside if self._is_sideways else ahead) * math.sin(bearing)
        speed = max(math.hypot(vx, vy), 1.0) if normalized else 1.0
        return vx / speed, vy / speed

    @property
    def radius_extend(self) -> float:
        """Radius of the least circle around it, and 0.1 m more."""
        return float(self._of(self._model.radius)) + MARGIN

    @property
    def centroid(self) -> Floats:
        """x, y of the middle of its area [m], shape ``(2,)``."""
        return self._vector(np.array(self._middle()))

    def _middle(self) -> tuple[float, float]:
        x, y, heading = map(float, self._state.pose[self._world, self.id])
        ahead, left = map(float, self._of(self._model.centroid))
        cosine, sine = math.cos(heading), math.sin(heading)
        return x + cosine * ahead - sine * left, y + sine * ahead + cosine * left

    @property
    def rvo_state(self) -> list[float]:
        """x, y, vx, vy, ``radius_extend``, desired vx and vy, heading [m, m/s, rad]."""
        x, y, heading = map(float, self._state.pose[self._world, self.id])
        return [x, y, *self._moving(), self.radius_extend, *self._desired(), heading]

    @property
    def rvo_neighbor_state(self) -> list[float]:
        """X and y of its centroid, vx, vy, ``radius_extend`` [m, m/s]."""
        return [*self._middle(), *self._moving(), self.radius_extend]

    @property
    def rvo_line_segments(self) -> list[list[float]]:
        """Both ends of each piece of a linestring, x, y, x, y [m]; none for other shapes."""
        first = self._model.segment_start[self.id]
        rows = self._state.segments[self._world, first : first + self._of(self._model.segment_count)]
        return [list(map(float, row)) for row in rows] if self.shape == "linestring" else []

    @property
    def state_dim(self) -> int:
        """How many numbers ``state`` has."""
        return int(self.state.size)

    @property
    def state_shape(self) -> tuple[int, ...]:
        """Shape of ``state``."""
        return self.state.shape

    @property
    def vel_dim(self) -> int:
        """How many numbers a command of its drive has."""
        return self._command_size

    @property
    def vel_shape(self) -> tuple[int, ...]:
        """Shape of ``vel_max``."""
        return (self._command_size, 1) if self._columns else (self._command_size,)

    @property
    def abbr(self) -> str:
        """The short name that pictures show: first letter of its role, and its number."""
        return f"{self.role[0]}{self.id}"

    def get_lidar_scan(self) -> dict[str, Any]:
        """Return the latest scan of its first range sensor; see ``scan``."""
        return self.scan()

    def get_lidar_points(self) -> Floats | None:
        """Return the points that its first range sensor hit; see ``scan_points``."""
        return self.scan_points()

    def get_lidar_offset(self) -> tuple[float, float, float] | None:
        """Return the mount pose of its first sensor in the body frame [m, m, rad], None without one."""
        return self.lidar_offset

    @property
    def time(self) -> float:
        """Time since the start of the episode [s]."""
        return float(self._state.time[self._world])

    @property
    def step_time(self) -> float:
        """Duration of a step [s]."""
        return float(self._model.step_time[0])
