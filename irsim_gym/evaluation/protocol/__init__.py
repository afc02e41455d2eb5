"""A policy drives each level once; results become tables.

No kind of policy.
"""
