"""Stands for nav_msgs."""
