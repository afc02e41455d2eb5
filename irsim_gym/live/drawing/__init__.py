"""Marks that a script draws over a world.

No pixels: marks are data.
"""
