"""What a body occupies."""

from irsim_gym.families import FOOTPRINTS
from irsim_gym.footprints.circle import Circle
from irsim_gym.footprints.compound import Compound
from irsim_gym.footprints.linestring import Linestring
from irsim_gym.footprints.polygon import Polygon
from irsim_gym.footprints.rectangle import Rectangle

FOOTPRINTS.register("circle", Circle)
FOOTPRINTS.register("rectangle", Rectangle)
FOOTPRINTS.register("polygon", Polygon)
FOOTPRINTS.register("linestring", Linestring)
FOOTPRINTS.register("compound", Compound)
