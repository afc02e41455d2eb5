"""A way over poses, searched in time, and how it is followed.

Only parts of ``hybrid_astar``.
"""
