"""Behaviours written in plain Python, ours and IR-SIM's, and what they see.

Nothing here is a kernel.
"""
