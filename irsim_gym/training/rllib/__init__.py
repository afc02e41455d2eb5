"""Training with Ray RLlib.

The only folder of ``training`` with Ray.
"""
