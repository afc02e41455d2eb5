"""Worlds that scripts step, as in IR-SIM, in the same simulator."""

from irsim_gym.live.body_info import HalfPlanes, ObstacleInfo, RobotInfo
from irsim_gym.live.drawing import Drawing, Drawn
from irsim_gym.live.grid_map import GridMap
from irsim_gym.world.irsim_readings import IrSimReadings
from irsim_gym.world.sensor_view import SensorView

__all__ = ["Drawing", "Drawn", "GridMap", "HalfPlanes", "IrSimReadings", "ObstacleInfo", "RobotInfo", "SensorView"]
