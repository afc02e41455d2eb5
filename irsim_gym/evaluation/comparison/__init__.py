"""Several policies on the same levels: results, films, demonstrations.

No protocol of its own.
"""
