"""What terms of plugins have to keep.

Nothing that a term of ours needs.
"""
