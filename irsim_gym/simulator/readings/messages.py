"""Messages of a world and its bodies, with the names and fields of ``irsim.msg``, most of which are those of ROS."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Floats, Rays

N_COVARIANCES = 36


class Message:
    """The base class of messages."""

    def to_dict(self) -> dict[str, Any]:
        """Return the message as data for JSON: mappings, lists, numbers and text."""
        return asdict(self, dict_factory=_plain)  # type: ignore[call-overload, no-any-return]


def _plain(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in pairs}


def _no_covariance() -> Floats:
    return np.zeros(N_COVARIANCES)


@dataclass
class Header(Message):
    """Number and time [s] of a message, and the frame that it refers to."""

    seq: int = 0
    stamp: Any = 0.0
    frame_id: str = "world"


@dataclass
class Point(Message):
    """A place [m]."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass
class Vector3(Point):
    """A direction with a length, or rates about three axes."""


@dataclass
class Quaternion(Message):
    """A rotation."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0

    @classmethod
    def from_yaw(cls, yaw: float) -> Self:
        """Return the rotation about the z axis by an angle [rad]."""
        return cls(z=math.sin(0.5 * yaw), w=math.cos(0.5 * yaw))

    def to_yaw(self) -> float:
        """Return the angle about the z axis [rad].

        Raises:
            ValueError: The quaternion is zero, which is no rotation.
        """
        square = self.x**2 + self.y**2 + self.z**2 + self.w**2
        if not square > 0.0:
            raise ValueError("the orientation is zero, which is no rotation")
        return math.atan2(2.0 * (self.w * self.z + self.x * self.y), square - 2.0 * (self.y**2 + self.z**2))


@dataclass
class Pose(Message):
    """A place and a rotation."""

    position: Point = field(default_factory=Point)
    orientation: Quaternion = field(default_factory=Quaternion)


@dataclass
class PoseWithCovariance(Message):
    """A pose, and how well it is known, ``(36,)``."""

    pose: Pose = field(default_factory=Pose)
    covariance: Floats = field(default_factory=_no_covariance)


@dataclass
class Twist(Message):
    """Velocity [m/s] and rates [rad/s]."""

    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@dataclass
class TwistWithCovariance(Message):
    """A twist, and how well it is known, ``(36,)``."""

    twist: Twist = field(default_factory=Twist)
    covariance: Floats = field(default_factory=_no_covariance)


@dataclass
class Odometry(Message):
    """A pose in the frame of the header, and a twist in the body frame ``child_frame_id``."""

    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)
    twist: TwistWithCovariance = field(default_factory=TwistWithCovariance)


@dataclass
class LaserScan(Message):
    """Ranges [m], float32, by angle [rad] from ``angle_min`` in steps of ``angle_increment``."""

    header: Header
    angle_min: float
    angle_max: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float
    ranges: Rays
    intensities: Rays


@dataclass
class ContactState(Message):
    """A contact of bodies with masses. Bodies have none here, so no message holds one."""

    other_id: int = -1
    other: str = ""
    point: Point = field(default_factory=Point)
    normal: Vector3 = field(default_factory=Vector3)
    depth: float = 0.0
    force: float = 0.0


@dataclass
class ObjectState(Message):
    """One body. ``contact_force``, ``contact_time``, ``air_time`` and ``contacts`` keep their defaults."""

    header: Header
    id: int
    name: str
    role: str
    kinematics: str | None
    shape: str
    odom: Odometry
    scan: LaserScan | None
    goal: NDArray[Any] | None
    static: bool
    arrive: bool
    collision: bool
    collision_ids: list[int] = field(default_factory=list)
    scans: list[LaserScan] = field(default_factory=list)
    contact_force: Vector3 = field(default_factory=Vector3)
    contact_time: float = 0.0
    air_time: float = 0.0
    contacts: list[ContactState] = field(default_factory=list)

    @property
    def sensors(self) -> list[LaserScan]:
        """``scans``."""
        return self.scans


@dataclass
class WorldState(Message):
    """A world with all of its bodies."""

    header: Header
    name: str
    status: str
    step_time: float
    objects: list[ObjectState] = field(default_factory=list)

    @property
    def robots(self) -> list[ObjectState]:
        """The robots."""
        return [one for one in self.objects if one.role == "robot"]

    @property
    def obstacles(self) -> list[ObjectState]:
        """The obstacles."""
        return [one for one in self.objects if one.role == "obstacle"]


def planar_pose(x: float, y: float, heading: float) -> Pose:
    """Return a pose on the plane [m, m, rad]."""
    return Pose(Point(float(x), float(y)), Quaternion.from_yaw(float(heading)))


def planar_twist(ahead: float, left: float, rate: float) -> Twist:
    """Return a twist on the plane in the body frame [m/s, m/s, rad/s]."""
    return Twist(Vector3(float(ahead), float(left)), Vector3(z=float(rate)))


def scan_message(header: Header, options: Any, angles: Floats, ranges: Rays) -> LaserScan:
    """Return the message of a range sensor.

    Args:
        header: Its header.
        options: Options of the sensor.
        angles: Directions of its beams [rad], ``(n_beams,)``.
        ranges: Their ranges [m], ``(n_beams,)``.
    """
    step = float(angles[-1] - angles[0]) / max(len(angles) - 1, 1)
    ends = float(angles[0]), float(angles[-1])
    limits = options.scan_time, options.range_min, options.range_max
    return LaserScan(header, *ends, step, 0.0, *limits, np.array(ranges, np.float32), np.zeros(0, np.float32))
