"""Worlds that scripts step, as in IR-SIM, in the same simulator.

No task and no environment.
"""

from irsim_gym.live.drawing.drawing import Drawing, Drawn
from irsim_gym.live.planning.grid_map import GridMap
from irsim_gym.live.population.body_info import HalfPlanes, ObstacleInfo, RobotInfo
from irsim_gym.simulator.readings.irsim_readings import IrSimReadings
from irsim_gym.simulator.readings.sensor_view import SensorView

__all__ = ["Drawing", "Drawn", "GridMap", "HalfPlanes", "IrSimReadings", "ObstacleInfo", "RobotInfo", "SensorView"]
