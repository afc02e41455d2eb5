"""The models that a file becomes, and the shipped files.

Only frozen data.
"""
