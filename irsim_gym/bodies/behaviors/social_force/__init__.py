"""Forces between people, groups and walls.

Only parts of ``social_force``.
"""
