"""What a body perceives.

One file for each sensor, named as in YAML, and the parts of a scan.
"""

from irsim_gym.base.families import SENSORS
from irsim_gym.bodies.sensors.contact2d import Contact2D
from irsim_gym.bodies.sensors.fmcw_lidar2d import FmcwLidar2D
from irsim_gym.bodies.sensors.lidar2d import Lidar2D

SENSORS.register("lidar2d", Lidar2D)
SENSORS.register("fmcw_lidar2d", FmcwLidar2D)
SENSORS.register("contact2d", Contact2D)
