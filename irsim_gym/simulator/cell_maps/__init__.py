"""Occupancy maps as cells: their room, and rays through them.

Only kernels on ``CellMap``.
"""
