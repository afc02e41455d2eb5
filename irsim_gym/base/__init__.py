"""What everything stands on: errors, registries, options, array types, files from outside.

It imports no other room.
"""
