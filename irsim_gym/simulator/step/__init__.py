"""The order of a step, and its phases.

A phase reads and writes ``Model`` and ``State``.
"""
