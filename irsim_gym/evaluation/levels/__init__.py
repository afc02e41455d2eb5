"""Levels as data: drawn, imported, certified, measured.

How worlds take them is in ``simulator.levels``.
"""
