"""One body of one world, read for people: poses, outlines, marks, trails, IR-SIM's names.

Nothing here writes a state.
"""
