"""Grids and planners under IR-SIM's names.

The searches are in ``simulator``.
"""
