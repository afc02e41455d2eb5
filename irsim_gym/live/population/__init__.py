"""The bodies of a world: adding, removing, reading, moving.

No pictures.
"""
