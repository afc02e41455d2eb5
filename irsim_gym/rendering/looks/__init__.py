"""Colours, fonts, images, styles.

Nothing that knows a body.
"""
