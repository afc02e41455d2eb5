"""Kinds of occupancy maps: given cells, or cells drawn for each level."""

from irsim_gym.families import MAPS
from irsim_gym.maps.array import ArrayMap
from irsim_gym.maps.cells import RandomCells
from irsim_gym.maps.cellular import CellularMap
from irsim_gym.maps.image import ImageMap
from irsim_gym.maps.maze import MazeMap
from irsim_gym.maps.perlin import PerlinMap
from irsim_gym.maps.rooms import RoomsMap
from irsim_gym.maps.shelves import ShelvesMap

MAPS.register("image", ImageMap)
MAPS.register("perlin", PerlinMap)
MAPS.register("array", ArrayMap)
MAPS.register("cells", RandomCells)
MAPS.register("rooms", RoomsMap)
MAPS.register("maze", MazeMap)
MAPS.register("cellular", CellularMap)
MAPS.register("shelves", ShelvesMap)
