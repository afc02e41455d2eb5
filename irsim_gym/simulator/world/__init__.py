"""What is stored: arrays from their declarations, groups, and what each family of kinds requires.

No phase of a step.
"""
