"""Pictures, films and windows of a world.

It asks ``rendering`` and draws nothing.
"""
