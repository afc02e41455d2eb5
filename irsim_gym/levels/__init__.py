"""Levels as data: drawn into files, converted from other collections, measured and shown."""
