"""A path is followed with room to stop.

Only parts of ``pursuit``.
"""
