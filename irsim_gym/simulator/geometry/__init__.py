"""Plane geometry: angles, segments, polygons, overlap, rays.

Only kernels on numbers and small arrays.
"""
