"""Stands for launch_ros."""
