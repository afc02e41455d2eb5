"""How levels begin: given or drawn, checked, with traits of their own.

Levels as files are in ``scenario`` and ``evaluation.levels``.
"""
