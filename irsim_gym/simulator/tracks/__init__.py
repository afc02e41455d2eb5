"""Tracks of what moves, from a body's own scans: clusters of points, discs that follow them, proofs that they move.

Only kernels on scans, and the memory that they write.
"""
