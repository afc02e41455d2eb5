"""Plane geometry as pure kernels on numbers and small arrays."""
