"""The content of a figure or page, as data, read from a simulation.

No pixels.
"""
