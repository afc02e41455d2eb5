"""A task as data: read, checked, compared with its scenario.

Nothing that runs in a step.
"""
