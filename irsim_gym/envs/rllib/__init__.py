"""Ray RLlib: runners and batches.

The only folder with Ray, but for ``training.rllib``.
"""
