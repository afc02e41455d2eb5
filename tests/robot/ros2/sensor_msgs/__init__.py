"""Stands for sensor_msgs."""
