"""Kernels that paint areas with smooth edges into image arrays, without a drawing library."""
