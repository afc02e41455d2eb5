"""What a bag holds of the topics that concern a driver."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from irsim_gym.base.errors import IrsimGymError, UnreadableFileError, suggestion
from irsim_gym.base.outside_files import reading

KIND = "bag of ROS"
TOPICS = {"scan": "/scan", "odometry": "/odom", "goal": "/goal_pose", "path": "/plan", "command": "/cmd_vel"}
"""Usual topic of each role."""


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
        UnreadableFileError: It is no bag, it is damaged, or a topic is not there.
        IrsimGymError: There is no such role.
    """
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    for role in topics:
        if role not in TOPICS:
            raise IrsimGymError(f"no role '{role}'{suggestion(role, TOPICS)}; roles are {', '.join(TOPICS)}")
    usual = {role: topic for role, topic in TOPICS.items() if role not in topics}
    roles = {topic: role for role, topic in {**usual, **topics}.items()}
    if file.is_dir() and not (file / "metadata.yaml").is_file():
        raise UnreadableFileError(str(file), KIND, "the folder has no metadata.yaml")
    with reading(file, KIND), AnyReader([file], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        chosen = [item for item in reader.connections if item.topic in roles]
        there = ", ".join(f"{item.topic} ({item.msgtype.rsplit('/', 1)[-1]})" for item in reader.connections)
        events = [
            Event(1e-9 * time, roles[item.topic], reader.deserialize(content, item.msgtype))
            for item, time, content in (reader.messages(chosen) if chosen else ())
        ]
    lacking = [topic for topic in topics.values() if not any(item.topic == topic for item in chosen)]
    if lacking or not events:
        expected = ", ".join(lacking or TOPICS.values())
        raise UnreadableFileError(str(file), f"bag with messages of {expected}", f"its topics are {there or 'none'}")
    return Bag(file, sorted(events, key=lambda event: (event.time, event.role == "command")))


def twist(message: Any) -> tuple[float, float, float]:
    """Return ahead, left [m/s] and the turn rate [rad/s] of a Twist, TwistStamped or Odometry."""
    while hasattr(message, "twist"):
        message = message.twist
    return float(message.linear.x), float(message.linear.y), float(message.angular.z)
