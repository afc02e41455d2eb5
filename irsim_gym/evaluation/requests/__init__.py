"""What commands ask for: a scenario with its task, checked together, as in training.

No command.
"""
