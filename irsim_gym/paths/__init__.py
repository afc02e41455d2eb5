"""How far a body is from its goal: free space, reachability and geodesic distance.

The moving body is a disc of some radius. It must not touch what is in its way: see ``clearance.Obstacles``.
"""
