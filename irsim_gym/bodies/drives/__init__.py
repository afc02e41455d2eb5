"""How a body moves.

One file for each drive, named as in YAML.
"""

from irsim_gym.base.families import KINEMATICS
from irsim_gym.bodies.drives.ackermann import Ackermann
from irsim_gym.bodies.drives.differential import Differential
from irsim_gym.bodies.drives.omni import Omni
from irsim_gym.bodies.drives.omni_angular import OmniAngular

KINEMATICS.register("diff", Differential)
KINEMATICS.register("omni", Omni)
KINEMATICS.register("omni_angular", OmniAngular)
KINEMATICS.register("acker", Ackermann)
