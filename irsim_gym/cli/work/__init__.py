"""What commands do.

Output and order; the rest is in the rooms below.
"""
