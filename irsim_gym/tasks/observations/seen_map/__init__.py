"""Observations of a map that the robot has seen.

Only kinds and what they share.
"""
