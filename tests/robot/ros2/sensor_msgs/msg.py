"""Stands for sensor_msgs."""

from typing import Any

from standing_messages import message

LaserScan: Any = message("sensor_msgs/msg/LaserScan")
