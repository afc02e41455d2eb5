"""Stable-Baselines3: vector environments, teams, buffers.

No network and no algorithm.
"""
