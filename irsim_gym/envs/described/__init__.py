"""What each number means, and the present of a world.

No adapter.
"""
