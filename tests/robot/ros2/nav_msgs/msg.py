"""Stands for nav_msgs."""

from typing import Any

from standing_messages import message

Odometry: Any = message("nav_msgs/msg/Odometry")
Path: Any = message("nav_msgs/msg/Path")
