"""Ways over cells: costs, queries, what a scan has shown.

Only what counts in cells; ways around outlines are in ``paths``.
"""
