"""Many learners: PettingZoo, arrays, tensors.

No learning library.
"""
