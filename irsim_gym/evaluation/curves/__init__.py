"""Curves of success over the strength of disturbances."""
