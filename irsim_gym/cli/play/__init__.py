"""A person drives.

The loop of ``play``.
"""
