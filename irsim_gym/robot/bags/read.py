"""What a bag holds of the topics that concern a driver."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.base.errors import UnreadableFileError
from irsim_gym.base.outside_files import reading

KIND = "bag of ROS"
ROLES = {
    "scan": ("/scan", "LaserScan"),
    "odometry": ("/odom", "Odometry"),
    "command": ("/cmd_vel", "Twist", "TwistStamped"),
    "goal": ("/goal_pose", "PoseStamped"),
    "path": ("/plan", "Path"),
}
"""Usual topic of each role, and its types of messages."""
COMMON = ("scan", "odometry", "command")
"""Roles that take a topic of another name if it is the only one of its type."""


class Event(NamedTuple):
    """A message of a bag: when it was recorded [s], and its role."""

    time: float
    role: str
    message: Any


class Bag(NamedTuple):
    """The messages of a bag in the order of their recording; of those of one time, commands come last."""

    file: Path
    events: Sequence[Event]

    def of(self, role: str) -> list[Event]:
        """Return the messages of a role."""
        return [event for event in self.events if event.role == role]


def read_bag(file: Path, topics: Mapping[str, str]) -> Bag:
    """Return the messages of a bag of ROS 2 (a folder, or its .mcap or .db3 file) or of ROS 1 (.bag).

    Args:
        file: The bag.
        topics: Topics of roles, where they are not the usual ones.

    Raises:
        UnreadableFileError: It is no bag, or damaged; a topic is not there, or there are several for a role.
    """
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    if file.is_dir() and not (file / "metadata.yaml").is_file():
        raise UnreadableFileError(str(file), KIND, "the folder has no metadata.yaml")
    with reading(file, KIND), AnyReader([file], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        roles = _roles(file, {one.topic: one.msgtype.rsplit("/", 1)[-1] for one in reader.connections}, topics)
        chosen = [one for one in reader.connections if one.topic in roles]
        events = [
            Event(1e-9 * time, roles[one.topic], reader.deserialize(content, one.msgtype))
            for one, time, content in reader.messages(chosen)
        ]
        if not events:
            raise ValueError(f"it has no messages of {', '.join(roles)}")
    return Bag(file, sorted(events, key=lambda event: (event.time, event.role == "command")))


def _roles(file: Path, types: Mapping[str, str], topics: Mapping[str, str]) -> dict[str, str]:
    """Return the role of each topic.

    Raises:
        UnreadableFileError: A topic is not there, or there are several for a role.
    """
    there = f"its topics are {', '.join(f'{topic} ({kind})' for topic, kind in types.items()) or 'none'}"
    found: dict[str, str] = {}
    for role, (usual, *kinds) in ROLES.items():
        fitting = [topic for topic, kind in types.items() if kind in kinds]
        topic = topics.get(role) or (usual if usual in fitting or role not in COMMON else "".join(fitting[:1]))
        if topic in fitting:
            found[topic] = role
        elif role in topics:
            raise UnreadableFileError(str(file), f"bag with {' or '.join(kinds)} in {topic}", there)
        if len(fitting) > 1 and topic not in (usual, topics.get(role)):
            reason = f"it has {', '.join(fitting)}: name one with --topic {role}=TOPIC"
            raise UnreadableFileError(str(file), f"bag with one topic of {kinds[0]}", reason)
    if not set(found.values()) & set(COMMON):
        raise UnreadableFileError(str(file), "bag of a drive", f"there are no scans, odometry or commands; {there}")
    return found


def seconds(stamp: Any) -> float:
    """Return the time of a stamp [s]."""
    return float(stamp.sec) + 1e-9 * stamp.nanosec


def twist(message: Any) -> tuple[float, float, float]:
    """Return ahead, left [m/s] and the turn rate [rad/s] of a Twist, TwistStamped or Odometry."""
    while hasattr(message, "twist"):
        message = message.twist
    return float(message.linear.x), float(message.linear.y), float(message.angular.z)


def lost_beams(message: Any, no_return: str) -> Flags:
    """Return which beams of a scan are lost, as the driver counts them: NaN, or shorter than ``range_min``."""
    ranges = np.asarray(message.ranges)
    lost: Flags = np.isnan(ranges) | ((ranges < message.range_min) & np.isfinite(ranges))
    return lost & (ranges != 0.0) if no_return == "zero" else lost
