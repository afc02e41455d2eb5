"""A trained network as plain arrays, and a policy for a loop of one's own.

Reading them is in ``evaluation.saved_policies``.
"""
