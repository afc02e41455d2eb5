"""Many frames: films, sheets, strobes, and the renderer of a simulation.

No drawing of one frame.
"""
