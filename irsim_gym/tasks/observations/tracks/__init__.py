"""Observations of moving bodies as a robot's own scans show them.

Only kinds and what they share.
"""
