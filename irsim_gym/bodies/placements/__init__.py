"""Where bodies start.

One file for each distribution, named as in YAML.
"""

from irsim_gym.base.families import PLACEMENTS
from irsim_gym.bodies.placements.cells import CellPlacement
from irsim_gym.bodies.placements.circle import CirclePlacement
from irsim_gym.bodies.placements.manual import ManualPlacement
from irsim_gym.bodies.placements.random import RandomPlacement

PLACEMENTS.register("manual", ManualPlacement)
PLACEMENTS.register("circle", CirclePlacement)
PLACEMENTS.register("random", RandomPlacement)
PLACEMENTS.register("cells", CellPlacement)
