"""Which area a body occupies.

One file for each shape, named as in YAML.
"""

from irsim_gym.base.families import FOOTPRINTS
from irsim_gym.bodies.shapes.circle import Circle
from irsim_gym.bodies.shapes.compound import Compound
from irsim_gym.bodies.shapes.linestring import Linestring
from irsim_gym.bodies.shapes.polygon import Polygon
from irsim_gym.bodies.shapes.rectangle import Rectangle

FOOTPRINTS.register("circle", Circle)
FOOTPRINTS.register("rectangle", Rectangle)
FOOTPRINTS.register("polygon", Polygon)
FOOTPRINTS.register("linestring", Linestring)
FOOTPRINTS.register("compound", Compound)
