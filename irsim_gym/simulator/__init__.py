"""What happens in a step: arrays, geometry, paths, contacts, the order of phases.

It knows no kind of body, no task and no picture: it calls ``group.kind``.
"""
