"""Stable-Baselines3: policies, algorithms and callbacks of ours.

No environment.
"""
