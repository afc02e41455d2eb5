"""Searches for hyper-parameters and seeds, with Optuna.

No training of their own.
"""
