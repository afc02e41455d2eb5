"""The ROS side of a simulated robot, under the Python of the system.

A line of JSON names a method of ``Robot`` and its arguments; a line with what it returns is the answer.
"""

from __future__ import annotations

import json
import os
import queue
import sys
import time

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped, Quaternion, TransformStamped, Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from tf2_ros import StaticTransformBroadcaster

answers = os.fdopen(os.dup(1), "w", buffering=1)
os.dup2(2, 1)  # ROS writes to the standard output, too


def turned(heading: float) -> Quaternion:
    return Quaternion(z=np.sin(0.5 * heading), w=np.cos(0.5 * heading))


class Robot:
    """Publishes what is asked for, and hears commands."""

    def __init__(self) -> None:
        rospy.set_param("/use_sim_time", True)
        rospy.init_node("robot", disable_signals=True)
        self.clock = rospy.Publisher("/clock", Clock, queue_size=1)
        self.scans = rospy.Publisher("scan", LaserScan, queue_size=1, tcp_nodelay=True)
        self.odometry = rospy.Publisher("odom", Odometry, queue_size=1, tcp_nodelay=True)
        self.goals = rospy.Publisher("goal_pose", PoseStamped, queue_size=1)
        self.transforms = StaticTransformBroadcaster()
        self.commands: queue.Queue[tuple[float, float]] = queue.Queue()
        rospy.Subscriber("cmd_vel", Twist, lambda msg: self.commands.put((msg.linear.x, msg.angular.z)))

    def wait(self, seconds: float) -> bool:
        """Return whether a node has connected with all topics in time."""
        end = time.monotonic() + seconds
        while min(one.get_num_connections() for one in (self.scans, self.odometry, self.goals)) < 1:
            if time.monotonic() > end:
                return False
            self.clock.publish(rospy.Time(1))
            time.sleep(0.05)
        time.sleep(0.5)  # its own publisher follows
        return True

    def goal(self, x: float, y: float, frame: str) -> None:
        """Publish a goal."""
        msg = PoseStamped()
        msg.header.frame_id, msg.pose.orientation = frame, turned(0.0)
        msg.pose.position.x, msg.pose.position.y = x, y
        self.goals.publish(msg)

    def lies(self, parent: str, child: str, x: float, y: float, heading: float) -> None:
        """Publish where a frame lies."""
        msg = TransformStamped(child_frame_id=child)
        msg.header.frame_id, msg.transform.rotation = parent, turned(heading)
        msg.transform.translation.x, msg.transform.translation.y = x, y
        self.transforms.sendTransform(msg)

    def step(
        self, now: float, ranges: list[float], first: float, step: float, place: list[float], pause: float
    ) -> list[float]:
        """Publish what the robot measures now, and return the command that follows; empty if none comes in 5 s.

        With a pause [s], the clock moves when the messages have arrived.
        """
        self.heard()
        stamp = rospy.Time.from_sec(now)
        if not pause:
            self.clock.publish(stamp)
        msg = Odometry(child_frame_id="base_link")
        msg.header.stamp, msg.header.frame_id = stamp, "odom"
        msg.pose.pose.position.x, msg.pose.pose.position.y = place[:2]
        msg.pose.pose.orientation = turned(place[2])
        msg.twist.twist.linear.x, msg.twist.twist.angular.z = place[3:]
        self.odometry.publish(msg)
        scan = LaserScan(angle_min=first, angle_increment=step, range_max=6.0)
        scan.header.stamp, scan.header.frame_id = stamp, "laser"
        scan.angle_max, scan.ranges = first + step * (len(ranges) - 1), ranges
        self.scans.publish(scan)
        if pause:
            time.sleep(pause)
            self.clock.publish(stamp)
        try:
            return list(self.commands.get(timeout=5.0))
        except queue.Empty:
            return []

    def silent(self, now: float) -> list[list[float]]:
        """Let time pass without messages; return the commands that come meanwhile."""
        self.heard()
        self.clock.publish(rospy.Time.from_sec(now))
        time.sleep(0.05)
        return self.heard()

    def heard(self) -> list[list[float]]:
        """Return the commands that have come."""
        return [list(self.commands.get()) for _ in range(self.commands.qsize())]

    def pause(self, seconds: float) -> None:
        """Let messages arrive."""
        time.sleep(seconds)


def main() -> None:
    robot = Robot()
    for line in sys.stdin:
        name, *given = json.loads(line)
        print(json.dumps(getattr(robot, name)(*given)), file=answers)


if __name__ == "__main__":
    main()
