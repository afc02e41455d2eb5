"""Observations of other bodies.

Only kinds.
"""
