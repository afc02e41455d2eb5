"""Observations of a range sensor.

Only kinds and what they share.
"""
