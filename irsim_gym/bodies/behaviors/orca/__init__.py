"""Optimal reciprocal collision avoidance.

Only parts of ``orca``.
"""
