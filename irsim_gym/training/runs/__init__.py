"""A run with Stable-Baselines3: environment, model, checkpoints, continuation.

No settings from files.
"""
