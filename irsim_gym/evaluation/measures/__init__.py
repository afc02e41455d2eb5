"""What is measured in an episode, and the statistics of many.

No tables and no files.
"""
