"""How a step runs: recorded, as one compiled call, on several threads.

The only room that steps in parallel.
"""
