"""The benchmark suite: members, records, scores, tables.

No statistics of its own.
"""
