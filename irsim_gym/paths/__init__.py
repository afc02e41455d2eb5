"""How far a body is from its goal: free space, reachability and geodesic distance.

The kernels take one world's outlines as eight tables in this order: ``segments`` (segment, 4), ``segment_start``,
``segment_count`` (body), ``discs`` (disc, 3), ``disc_start``, ``disc_count`` (body), ``solid`` (body) as in the
model and the state, and ``blocks`` (body): which bodies stand in the way; and as ninth ``cells``, the occupancy map as
``geometry.cells`` takes it, or None: its occupied cells are always in the way. The moving body is a disc of some radius
and must not touch them.
"""
