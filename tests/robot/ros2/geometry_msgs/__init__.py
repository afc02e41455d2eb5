"""Stands for geometry_msgs."""
