"""Which policy solves which level, and the page that shows it.

Its statistics are in ``measures``.
"""
