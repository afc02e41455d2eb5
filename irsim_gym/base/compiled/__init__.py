"""Compiled code on disk: its keys, folders, locks, whether it can be trusted, and who compiles it.

No kernel of the simulator.
"""
