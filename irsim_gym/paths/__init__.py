"""Paths of bodies: free space, reachability and geodesic distance.

The moving body is a disc that must not touch obstacles, see ``clearance.Obstacles``.
"""
