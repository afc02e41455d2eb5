"""What adapters share: spaces, infos, limits, levels, pictures, masks.

No learning library.
"""
