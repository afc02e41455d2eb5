"""Drives a robot by a policy."""
