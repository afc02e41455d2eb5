"""Policies on the same levels: who solves which one, and how the others fail."""
