"""Ray RLlib: runners and batches.

The only folder with Ray.
"""
