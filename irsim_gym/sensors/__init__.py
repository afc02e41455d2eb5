"""Sensors of bodies."""

from irsim_gym.families import SENSORS
from irsim_gym.sensors.fmcw_lidar2d import FmcwLidar2D
from irsim_gym.sensors.lidar2d import Lidar2D

SENSORS.register("lidar2d", Lidar2D)
SENSORS.register("fmcw_lidar2d", FmcwLidar2D)
