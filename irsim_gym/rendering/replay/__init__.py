"""Pages that play in a browser, and the data in them.

No other page.
"""
