"""Stands for geometry_msgs."""

from typing import Any

from standing_messages import message

PoseStamped: Any = message("geometry_msgs/msg/PoseStamped")
Twist: Any = message("geometry_msgs/msg/Twist")
TwistStamped: Any = message("geometry_msgs/msg/TwistStamped")
