"""What the parts of a world share: the simulation, levels, goals, steps.

No body and no picture.
"""
