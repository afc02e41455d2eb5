"""Many frames: films, and the renderer of a simulation.

No drawing of one frame.
"""
