"""Observations of goals and the way to them.

Only kinds and what they share.
"""
