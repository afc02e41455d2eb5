"""What a body perceives."""

from irsim_gym.families import SENSORS
from irsim_gym.sensors.lidar2d import Lidar2D

SENSORS.register("lidar2d", Lidar2D)
