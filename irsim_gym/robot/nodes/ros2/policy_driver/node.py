"""A ROS 2 life-cycle node around the driver: scans, odometry and a goal in, velocities out."""

import os
import signal
from functools import partial
from typing import Any

import rclpy
from ament_index_python.packages import get_package_share_directory
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.time import Time
from tf2_ros import Buffer, TransformListener

from irsim_gym.robot.nodes.driving import Driving


class DriverNode(LifecycleNode):
    """Topics scan, odom, goal_pose and plan in, cmd_vel out; parameters: see ``Driving.settings`` and on_configure."""

    def __init__(self) -> None:
        super().__init__("policy_driver")
        self.buffer, self.is_active = Buffer(), False
        self.listener = TransformListener(self.buffer, self)

    def _value(self, name: str, default: Any) -> Any:
        return (self.get_parameter(name) if self.has_parameter(name) else self.declare_parameter(name, default)).value

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load contract and graph, and listen."""
        contract = self._value("contract", f"{get_package_share_directory('policy_driver')}/contract.json")
        transform, log = partial(self.buffer.lookup_transform, time=Time()), self.get_logger()
        try:
            self.driving = Driving(contract, transform, log.info, self._drive)
        except (OSError, ValueError) as problem:
            log.error(str(problem))
            return TransitionCallbackReturn.FAILURE
        self.timer = self.create_timer(self.driving.use(self._value), self._drive)
        self.kind = TwistStamped if self._value("stamped", os.environ.get("ROS_DISTRO", "") >= "kilted") else Twist
        self.publisher = self.create_lifecycle_publisher(self.kind, "cmd_vel", 1)
        stream = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)  # a queue would be latency
        self.inputs = [
            self.create_subscription(kind, topic, take, stream if is_stream else 1)
            for topic, kind, take, is_stream in self.driving.topics()
        ]
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Drive from now on."""
        self.driving.begin()
        self.is_active = True
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop the robot, if it is driven, before the publisher falls silent."""
        if self.is_active:
            self.is_active = False
            self._send(0.0, 0.0, 0.0)
        return super().on_deactivate(state)

    on_shutdown = on_deactivate

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Hear and send nothing any more."""
        self.destroy_timer(self.timer)
        for subscription in self.inputs:
            self.destroy_subscription(subscription)
        self.destroy_lifecycle_publisher(self.publisher)
        return super().on_cleanup(state)

    def _drive(self) -> None:
        if self.is_active and (command := self.driving.command(self.get_clock().now().nanoseconds / 1e9)):
            self._send(*command)

    def _send(self, ahead: float, left: float, turn: float) -> None:
        msg = self.kind()
        twist = msg if self.kind is Twist else msg.twist
        twist.linear.x, twist.linear.y, twist.angular.z = ahead, left, turn
        if self.kind is TwistStamped:
            msg.header.stamp, msg.header.frame_id = self.get_clock().now().to_msg(), "base_link"
        self.publisher.publish(msg)


def main() -> None:
    """Run the node; a signal would by default end its context before the robot has been stopped."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    node, executor = DriverNode(), SingleThreadedExecutor()
    executor.add_node(node)
    try:
        while True:
            executor.spin_once(timeout_sec=0.1)
    except KeyboardInterrupt:
        pass
    finally:
        node.on_deactivate(LifecycleState("active", 3))
        rclpy.shutdown()
