"""Tables, schemas and summaries of the language, from its declarations.

Nothing is stated here a second time.
"""
