"""Many frames: films, sheets, and the renderer of a simulation.

No drawing of one frame.
"""
