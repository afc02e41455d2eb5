"""Kernels that draw pixels.

Only kernels and their records.
"""
