"""Sections of a file become entries: one mapping for each body.

Only IR-SIM's short forms and what they stand for.
"""
