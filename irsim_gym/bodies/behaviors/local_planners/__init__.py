"""``dwa``: its task, its way, its rollouts.

Only planners of the next command.
"""
