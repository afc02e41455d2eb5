"""Settings of a run, from files and options.

Nothing that trains.
"""
