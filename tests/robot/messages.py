"""ROS messages of a robot in the simulator: real types of rosbags, as scanners of several kinds send them."""

from __future__ import annotations

from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)


def made(name: str, **fields: Any) -> Any:
    """Return a message of a type such as ``std_msgs/msg/Header``."""
    return STORE.types[name](**fields)


def header(time: float, frame: str) -> Any:
    seconds, rest = divmod(round(time * 1e9), 1_000_000_000)
    stamp = made("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)
    return made("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def pose(x: float, y: float, heading: float) -> Any:
    half = 0.5 * heading
    turn = made("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=np.sin(half), w=np.cos(half))
    return made("geometry_msgs/msg/Pose", position=made("geometry_msgs/msg/Point", x=x, y=y, z=0.0), orientation=turn)


def goal(x: float, y: float, heading: float = 0.0, frame: str = "odom") -> Any:
    return made("geometry_msgs/msg/PoseStamped", header=header(0.0, frame), pose=pose(x, y, heading))


def path(places: list[tuple[float, float]], frame: str = "odom") -> Any:
    return made("nav_msgs/msg/Path", header=header(0.0, frame), poses=[goal(x, y) for x, y in places])


def odometry(time: float, place: Any, v: float = 0.0, w: float = 0.0) -> Any:
    twist = made(
        "geometry_msgs/msg/Twist",
        linear=made("geometry_msgs/msg/Vector3", x=v, y=0.0, z=0.0),
        angular=made("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=w),
    )
    return made(
        "nav_msgs/msg/Odometry",
        header=header(time, "odom"),
        child_frame_id="base_link",
        pose=made("geometry_msgs/msg/PoseWithCovariance", pose=pose(*place), covariance=np.zeros(36)),
        twist=made("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=np.zeros(36)),
    )


def scan(
    time: float,
    ranges: Any,
    *,
    clockwise: bool = False,
    zeros: bool = False,
    range_max: float = 6.0,
    view: float = 2.0 * np.pi,
) -> Any:
    """Return a scan about straight ahead; of a full turn, both ends look behind."""
    found, step = np.array(ranges, np.float32), view / (len(ranges) - 1)
    found[found >= range_max] = 0.0 if zeros else np.inf
    sign = -1.0 if clockwise else 1.0
    return made(
        "sensor_msgs/msg/LaserScan",
        header=header(time, "laser"),
        angle_min=-0.5 * sign * view,
        angle_max=0.5 * sign * view,
        angle_increment=sign * step,
        time_increment=0.0,
        scan_time=0.1,
        range_min=0.0,
        range_max=range_max,
        ranges=found[::-1].copy() if clockwise else found,
        intensities=np.zeros(0, np.float32),
    )
