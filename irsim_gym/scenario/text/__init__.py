"""YAML, expressions and messages: plain data with the lines it comes from.

Nothing that knows a key of the language.
"""
