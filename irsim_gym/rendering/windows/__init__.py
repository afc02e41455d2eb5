"""Windows in real time, and pictures in notebooks.

No drawing of frames.
"""
