"""Observations of the robot itself.

Only kinds.
"""
