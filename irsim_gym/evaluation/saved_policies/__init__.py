"""Policies on disk: runs, archives, the shelf, cards, and what may be unpickled.

Nothing that trains.
"""
