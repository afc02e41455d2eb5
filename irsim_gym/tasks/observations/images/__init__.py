"""Observations as pictures.

Only kinds and what they share.
"""
