"""Policies that need no file: behaviours, planners, references, functions.

Policies on disk are in ``saved_policies``.
"""
