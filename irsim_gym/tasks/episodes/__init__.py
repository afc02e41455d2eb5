"""Episodes in the worlds of a simulation: act, step, observe, pay, end.

No kind of term.
"""
