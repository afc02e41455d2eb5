"""What is wrong in a file that can be read: unknown and needless keys, values, where things are.

Only checks of files.
"""
