"""Which cells of the obstacle map are occupied, from a file or drawn for each level.

One file for each map, named as in YAML.
"""

from irsim_gym.base.families import MAPS
from irsim_gym.bodies.maps.array import ArrayMap
from irsim_gym.bodies.maps.cells import RandomCells
from irsim_gym.bodies.maps.cellular import CellularMap
from irsim_gym.bodies.maps.image import ImageMap
from irsim_gym.bodies.maps.maze import MazeMap
from irsim_gym.bodies.maps.perlin import PerlinMap
from irsim_gym.bodies.maps.rooms import RoomsMap
from irsim_gym.bodies.maps.ros import RosMap
from irsim_gym.bodies.maps.shelves import ShelvesMap

MAPS.register("image", ImageMap)
MAPS.register("ros", RosMap)
MAPS.register("perlin", PerlinMap)
MAPS.register("array", ArrayMap)
MAPS.register("cells", RandomCells)
MAPS.register("rooms", RoomsMap)
MAPS.register("maze", MazeMap)
MAPS.register("cellular", CellularMap)
MAPS.register("shelves", ShelvesMap)
