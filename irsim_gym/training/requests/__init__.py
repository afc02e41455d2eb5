"""What ``train`` is asked for, checked before it begins.

No command.
"""
