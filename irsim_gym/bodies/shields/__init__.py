"""What stands between a learner's commands and its drive, and changes those that are not safe.

One file for each shield, named as in YAML.
"""

from irsim_gym.base.families import SHIELDS
from irsim_gym.bodies.shields.stop_in_time import StopInTime
from irsim_gym.bodies.shields.velocity_obstacle import VelocityObstacle

SHIELDS.register("stop_in_time", StopInTime)
SHIELDS.register("velocity_obstacle", VelocityObstacle)
