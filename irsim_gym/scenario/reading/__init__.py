"""A file is read, step by step, into a ``Scenario``.

Only the steps of reading; the models are in ``specs``.
"""
