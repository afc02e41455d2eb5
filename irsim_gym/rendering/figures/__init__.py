"""Figures by matplotlib.

The only folder that draws with it.
"""
