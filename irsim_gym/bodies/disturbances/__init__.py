"""What makes a robot drive and measure otherwise than its entry says.

One file for each disturbance, named as in YAML. Their order here is the order in which they act.
"""

from irsim_gym.base.families import DISTURBANCES
from irsim_gym.bodies.disturbances.blind_sector import BlindSector
from irsim_gym.bodies.disturbances.drive_lag import DriveLag
from irsim_gym.bodies.disturbances.glass import Glass
from irsim_gym.bodies.disturbances.latency import Latency
from irsim_gym.bodies.disturbances.lost_beams import LostBeams
from irsim_gym.bodies.disturbances.lost_commands import LostCommands
from irsim_gym.bodies.disturbances.mount import Mount
from irsim_gym.bodies.disturbances.odometry import Odometry
from irsim_gym.bodies.disturbances.radius import Radius
from irsim_gym.bodies.disturbances.range_bias import RangeBias
from irsim_gym.bodies.disturbances.scan_rate import ScanRate
from irsim_gym.bodies.disturbances.slip import Slip

DISTURBANCES.register("radius", Radius)
DISTURBANCES.register("lost_commands", LostCommands)
DISTURBANCES.register("latency", Latency)
DISTURBANCES.register("drive_lag", DriveLag)
DISTURBANCES.register("slip", Slip)
DISTURBANCES.register("odometry", Odometry)
DISTURBANCES.register("mount", Mount)
DISTURBANCES.register("glass", Glass)
DISTURBANCES.register("range_bias", RangeBias)
DISTURBANCES.register("lost_beams", LostBeams)
DISTURBANCES.register("blind_sector", BlindSector)
DISTURBANCES.register("scan_rate", ScanRate)
