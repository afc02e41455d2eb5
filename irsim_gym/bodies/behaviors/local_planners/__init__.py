"""``dwa`` and ``mppi``, and what they share: a task, a way, rollouts.

Only planners of the next command.
"""
