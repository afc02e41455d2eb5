"""Bags of ROS, written and read without ROS: a drive replayed through an export, and what it says of a robot."""
