"""How a body moves."""

from irsim_gym.families import KINEMATICS
from irsim_gym.kinematics.ackermann import Ackermann
from irsim_gym.kinematics.differential import Differential
from irsim_gym.kinematics.omni import Omni
from irsim_gym.kinematics.omni_angular import OmniAngular

KINEMATICS.register("diff", Differential)
KINEMATICS.register("omni", Omni)
KINEMATICS.register("omni_angular", OmniAngular)
KINEMATICS.register("acker", Ackermann)
