"""A grid of free space, a proof that a way exists, the shortest way and its length.

Only kernels on obstacles and grids.
"""
