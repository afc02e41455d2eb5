"""ROS packages around the driver: what ``irsim-gym export --node`` writes beside an export."""
