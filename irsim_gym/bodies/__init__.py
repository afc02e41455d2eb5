"""What a body can be: drives, shapes, sensors, placements, maps, behaviours.

A kind knows the simulator, and no other kind.
"""
