"""Reciprocal velocity obstacles.

Only parts of ``rvo``.
"""
