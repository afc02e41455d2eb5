"""One frame, as pixels: what is drawn in which order, and what is kept from frame to frame.

No matplotlib.
"""
