"""Bodies that push each other (``collision_mode: contact``): masses, pairs, how they part, and what they feel.

No search for collisions, which is in ``contact``, and nothing that a step calls where bodies neither push nor coast.
"""
