"""Messages of a world and its bodies, with the names and fields of ``irsim.msg``, most of which are those of ROS."""

import math
from dataclasses import dataclass, field, make_dataclass
from typing import TYPE_CHECKING, Any, NoReturn, Self

import numpy as np

from irsim_gym.base.arraytypes import Floats, Rays
from irsim_gym.simulator.readings.irsim_names import advice, missing


class _Kind(type):
    """Says what to use in place of IR-SIM's ways to make a message."""

    if not TYPE_CHECKING:

        def __getattr__(cls, name: str) -> NoReturn:
            message = missing(f"the message {cls.__name__}", name, advice("message"), dir(cls))
            raise AttributeError(message, name=name, obj=cls)


class Message(metaclass=_Kind):
    """The base class of messages, which are dataclasses."""

    def to_dict(self) -> dict[str, Any]:
        """Return the message as plain data, which JSON can hold."""
        return {name: _plain(value) for name, value in vars(self).items()}


def _plain(value: Any) -> Any:
    if isinstance(value, list):
        return [_plain(entry) for entry in value]
    return value.to_dict() if isinstance(value, Message) else getattr(value, "tolist", lambda: value)()


def _message(kind: str, /, *bases: type, **defaults: Any) -> Any:
    """Return a class of messages; the default of a field is a value, or a function that makes it."""
    fields = [
        (name, Any, field(default_factory=value) if callable(value) else field(default=value))
        for name, value in defaults.items()
    ]
    return make_dataclass(kind, fields, bases=bases or (Message,), namespace={"__module__": __name__})


def _no_covariance() -> Floats:
    return np.zeros(36)


def _no_numbers() -> Rays:
    return np.zeros(0, np.float32)


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
        """Return the angle about the z axis [rad]; 0 for the quaternion zero, which is no rotation."""
        square = self.x**2 + self.y**2 + self.z**2 + self.w**2
        return math.atan2(2.0 * (self.w * self.z + self.x * self.y), square - 2.0 * (self.y**2 + self.z**2))


class _Grouped(Message):
    objects: list[Any]

    @property
    def robots(self) -> list[Any]:
        """The robots."""
        return [body for body in self.objects if body.role == "robot"]

    @property
    def obstacles(self) -> list[Any]:
        """The obstacles."""
        return [body for body in self.objects if body.role == "obstacle"]


Header = _message("Header", seq=0, stamp=0.0, frame_id="world")
Point = _message("Point", x=0.0, y=0.0, z=0.0)
Vector3 = _message("Vector3", x=0.0, y=0.0, z=0.0)
Pose = _message("Pose", position=Point, orientation=Quaternion)
PoseWithCovariance = _message("PoseWithCovariance", pose=Pose, covariance=_no_covariance)
Twist = _message("Twist", linear=Vector3, angular=Vector3)
TwistWithCovariance = _message("TwistWithCovariance", twist=Twist, covariance=_no_covariance)
Odometry = _message("Odometry", header=Header, child_frame_id="", pose=PoseWithCovariance, twist=TwistWithCovariance)
_ANGLES = {"angle_min": 0.0, "angle_max": 0.0, "angle_increment": 0.0}
_LIMITS = {"time_increment": 0.0, "scan_time": 0.0, "range_min": 0.0, "range_max": 0.0}
LaserScan = _message("LaserScan", header=Header, **_ANGLES, **_LIMITS, ranges=_no_numbers, intensities=_no_numbers)
ContactState = _message("ContactState", other_id=-1, other="", point=Point, normal=Vector3, depth=0.0, force=0.0)
_WHAT = {"id": 0, "name": "", "role": "", "kinematics": None, "shape": ""}
_FLAGS = {"static": False, "arrive": False, "collision": False, "collision_ids": list}
_CONTACTS = {"contact_force": Vector3, "contact_time": 0.0, "air_time": 0.0, "contacts": list}
_READ = {"odom": Odometry, "scan": None, "goal": None}
ObjectState = _message("ObjectState", header=Header, **_WHAT, **_READ, **_FLAGS, scans=list, **_CONTACTS)
"""One body. Contacts, their force and times are those of ``collision_mode: contact``, and zeros in other modes."""
WorldState = _message("WorldState", _Grouped, header=Header, name="", status="", step_time=0.0, objects=list)


def odometry(header: Any, child: str, pose: Floats, twist: Any) -> Any:
    """Return an odometry on the plane, with a pose [m, m, rad] and a twist in the body frame."""
    x, y, heading = map(float, pose)
    place = PoseWithCovariance(Pose(Point(x, y), Quaternion.from_yaw(heading)))
    return Odometry(header, child, place, TwistWithCovariance(twist))


def planar_twist(ahead: float, left: float, rate: float) -> Any:
    """Return a twist on the plane in the body frame [m/s, m/s, rad/s]."""
    return Twist(Vector3(float(ahead), float(left)), Vector3(z=float(rate)))


def scan_message(header: Any, options: Any, angles: Floats, ranges: Rays) -> Any:
    """Return the message of a range sensor.

    Args:
        header: Its header.
        options: Options of the sensor.
        angles: Directions of its beams [rad], ``(n_beams,)``.
        ranges: Their ranges [m], ``(n_beams,)``.
    """
    first, last = float(angles[0]), float(angles[-1])
    step = (last - first) / max(len(angles) - 1, 1)
    limits = options.scan_time, options.range_min, options.range_max
    return LaserScan(header, first, last, step, 0.0, *limits, np.array(ranges, np.float32))
