"""How a training went: scores of checkpoints, seeds, signs of failure.

Nothing that trains.
"""
