#!/usr/bin/env python3
"""A ROS 1 node around the driver: scans, odometry and a goal in, velocities out."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import rospkg
import rospy
from geometry_msgs.msg import Twist
from tf2_ros import Buffer, TransformListener

from irsim_gym.robot.nodes.driving import Driving


class DriverNode:
    """Drives by a policy: topics scan, odom, goal_pose and plan in, cmd_vel out.

    Its parameters are those of ``Driving.settings``, and ``contract``, the contract's path.
    """

    def __init__(self) -> None:
        self.lock, self.buffer = threading.RLock(), Buffer()  # each topic has a thread of its own
        self.listener = TransformListener(self.buffer)
        beside = str(Path(rospkg.RosPack().get_path("policy_driver")) / "contract.json")
        contract = rospy.get_param("~contract", beside)
        transform = partial(self.buffer.lookup_transform, time=rospy.Time())
        self.driving = driving = Driving(contract, transform, rospy.loginfo, self.drive)
        self.interval = driving.use(lambda name, default: rospy.get_param(f"~{name}", default))
        self.publisher = rospy.Publisher("cmd_vel", Twist, queue_size=1)
        rospy.on_shutdown(self.stop)
        for topic, kind, take, _ in driving.topics():
            rospy.Subscriber(topic, kind, self.hear, take, queue_size=1)

    def spin(self) -> None:
        """Drive until ROS ends; an error here ends the node, which stops the robot."""
        rate = rospy.Rate(1.0 / self.interval, reset=True)
        while not rospy.is_shutdown():
            with self.lock:
                self.drive()
            rate.sleep()

    def hear(self, msg: Any, take: Callable[[Any], None]) -> None:
        """Take a message."""
        with self.lock:
            take(msg)

    def drive(self) -> None:
        """Publish a command, if one is due."""
        command = self.driving.command(rospy.get_time())
        if command is not None and not rospy.is_shutdown():
            self.send(*command)

    def stop(self) -> None:
        """Let the robot stand."""
        with self.lock:
            self.send(0.0, 0.0, 0.0)

    def send(self, ahead: float, left: float, turn: float) -> None:
        """Publish a velocity."""
        msg = Twist()
        msg.linear.x, msg.linear.y, msg.angular.z = ahead, left, turn
        self.publisher.publish(msg)


def main() -> None:
    """Run the node."""
    rospy.init_node("policy_driver")
    with contextlib.suppress(rospy.ROSInterruptException):
        DriverNode().spin()


if __name__ == "__main__":
    main()
