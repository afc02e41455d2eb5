"""What a body tells, under the names that IR-SIM has for it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NoReturn

from irsim_gym.arraytypes import Floats
from irsim_gym.live import hints
from irsim_gym.live.reports import ObstacleInfo, RobotInfo
from irsim_gym.live.view_names import ViewNames
from irsim_gym.world.model import OMNI_BODY, OMNI_WORLD

if TYPE_CHECKING:
    from typing import Self


class BodyNames(ViewNames):
    """IR-SIM's names, and for those that are not here an error that says what to use."""

    __slots__ = ()

    if not TYPE_CHECKING:  # a checker of types would otherwise take any name for known

        def __getattr__(self, name: str) -> NoReturn:
            if name in dir(type(self)) or name.startswith("_"):
                object.__getattribute__(self, name)  # tells what went wrong in a property
            raise AttributeError(hints.missing("a body", name, hints.BODY, dir(self)), name=name, obj=self)

        def __setattr__(self, name: str, value: Any) -> None:
            if not name.startswith("_"):
                raise AttributeError(hints.unsettable(name, dir(self)), name=name, obj=self)
            object.__setattr__(self, name, value)

    @property
    def arrive(self) -> bool:
        """IR-SIM's name for ``arrived``."""
        return self.arrived

    @property
    def arrive_flag(self) -> bool:
        """IR-SIM's name for ``arrived``."""
        return self.arrived

    @property
    def collision(self) -> bool:
        """IR-SIM's name for ``collided``."""
        return self.collided

    @property
    def collision_flag(self) -> bool:
        """IR-SIM's name for ``collided``."""
        return self.collided

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
        return self._vector(self._simulation.state.pose[0, self._b, :2])

    @property
    def orientation(self) -> float:
        """Heading of its own frame [rad]."""
        return float(self._simulation.state.pose[0, self._b, 2])

    @property
    def heading(self) -> float:
        """Where it drives to [rad]: for ``omni`` the direction of its velocity while it moves, else ``orientation``."""
        vx, vy = map(float, self._simulation.state.twist[0, self._b, :2])
        is_sideways = self._simulation.model.drive[self._b] in (OMNI_WORLD, OMNI_BODY)
        return math.atan2(vy, vx) if is_sideways and (vx or vy) else self.orientation

    @property
    def velocity_xy(self) -> Floats:
        """vx, vy in the world frame [m/s], shape ``(2,)``."""
        return self._vector(self._simulation.state.twist[0, self._b, :2])

    @property
    def shape(self) -> str:
        """Name of its shape; ``map`` for the obstacle map."""
        return self.info.shape

    @property
    def kinematics(self) -> str | None:
        """Name of its drive, None without one."""
        return self.info.kinematics

    @property
    def wheelbase(self) -> float | None:
        """Axle distance [m], None without one."""
        return self.info.wheelbase

    @property
    def vel_min(self) -> Floats:
        """Least velocities in the drive's coordinates [m/s or rad/s]."""
        return self._vector(self._simulation.model.velocity_min[0, self._b, : self._command_size])

    @property
    def vel_max(self) -> Floats:
        """Greatest velocities in the drive's coordinates [m/s or rad/s]."""
        return self._vector(self._simulation.model.velocity_max[0, self._b, : self._command_size])

    @property
    def acce(self) -> Floats:
        """Greatest changes per second [m/s2 or rad/s2]; may be infinite."""
        return self._vector(self._simulation.model.acceleration_limit[0, self._b, : self._command_size])

    @property
    def color(self) -> str:
        """Its colour."""
        return self.spec.color

    @property
    def description(self) -> str | None:
        """Image that it is drawn with, or None."""
        return self.spec.description

    @property
    def goal_threshold(self) -> float:
        """Distance under which a goal is reached [m]."""
        return self.spec.goal_threshold

    @property
    def arrive_mode(self) -> str:
        """``position`` or ``state``."""
        return self.spec.arrive_mode

    @property
    def angle_range(self) -> tuple[float, float]:
        """Interval that headings wrap into [rad]."""
        return self.spec.angle_range

    @property
    def unobstructed(self) -> bool:
        """Collisions and sensors ignore it, behaviours do not."""
        return self.spec.unobstructed

    @property
    def fov(self) -> float | None:
        """Width of its field of view [rad], None without one."""
        return self.spec.fov

    @property
    def fov_radius(self) -> float | None:
        """Depth of its field of view [m], None without one."""
        return self.spec.fov_radius

    @property
    def sensors(self) -> tuple[Any, ...]:
        """Options of its sensors, in the order of the file; ``scan(i)`` is what the i-th range sensor reads."""
        return self.spec.sensors

    @property
    def external_objects(self) -> list[Self]:
        """All other bodies."""
        names = self._world.names
        return [type(self)(self._world, name) for name in names if name != self._name]

    def get_info(self) -> RobotInfo:
        """Return what it is; IR-SIM's name for ``info``."""
        return self.info

    def get_obstacle_info(self) -> ObstacleInfo:
        """Return where it is; IR-SIM's name for ``obstacle_info``."""
        return self.obstacle_info

    def get_lidar_scan(self) -> dict[str, Any]:
        """Return the scan of its first range sensor; see ``scan``."""
        return self.scan()

    def get_lidar_points(self) -> Floats | None:
        """Return the points that its first range sensor hit; see ``scan_points``."""
        return self.scan_points()

    def get_lidar_offset(self) -> tuple[float, float, float] | None:
        """Return the mount pose of its first sensor in the body frame [m, m, rad], None without one."""
        return self.lidar_offset

    def get_fov_detected_objects(self) -> list[Self]:
        """Return the bodies in its field of view; see ``detected``."""
        return self.detected()

    def fov_detect_object(self, detected_object: ViewNames) -> bool:
        """Return whether a body is in its field of view; see ``detected``."""
        return detected_object in self.detected()
