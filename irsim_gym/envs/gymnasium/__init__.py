"""Gymnasium's environments, single and in batches, and their ids.

No other library.
"""
