"""Who touches whom: pairs, buckets, cells of a map, all along a step.

Only finding of contacts; what follows is in ``step``.
"""
