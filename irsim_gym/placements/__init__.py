"""Distributions: where bodies start, and their goals."""

from irsim_gym.families import PLACEMENTS
from irsim_gym.placements.cells import CellPlacement
from irsim_gym.placements.circle import CirclePlacement
from irsim_gym.placements.manual import ManualPlacement
from irsim_gym.placements.random import RandomPlacement

PLACEMENTS.register("manual", ManualPlacement)
PLACEMENTS.register("circle", CirclePlacement)
PLACEMENTS.register("random", RandomPlacement)
PLACEMENTS.register("cells", CellPlacement)
