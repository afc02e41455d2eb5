"""Arenas: which policy solves which level, and how the others fail."""
