"""Levels as data: drawn into files, imported from other collections, measured and shown."""
