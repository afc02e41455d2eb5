"""How a body moves."""

from irsim_gym.families import KINEMATICS
from irsim_gym.kinematics.differential import Differential

KINEMATICS.register("diff", Differential)
