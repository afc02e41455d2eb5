"""Behaviours: how bodies decide."""

from irsim_gym.behaviors.dash import Dash
from irsim_gym.behaviors.dwa import Dwa
from irsim_gym.behaviors.hybrid_astar import HybridAstar
from irsim_gym.behaviors.mppi import Mppi
from irsim_gym.behaviors.orca import OrcaGroup
from irsim_gym.behaviors.pursuit import Pursuit
from irsim_gym.behaviors.recorded import Recorded
from irsim_gym.behaviors.rvo import Rvo
from irsim_gym.behaviors.social_force import SocialForce
from irsim_gym.behaviors.social_force_group import SocialForceGroup
from irsim_gym.families import BEHAVIORS, GROUP_BEHAVIORS

BEHAVIORS.register("dash", Dash)
BEHAVIORS.register("dwa", Dwa)
BEHAVIORS.register("hybrid_astar", HybridAstar)
BEHAVIORS.register("mppi", Mppi)
BEHAVIORS.register("pursuit", Pursuit)
BEHAVIORS.register("recorded", Recorded)
BEHAVIORS.register("rvo", Rvo)
BEHAVIORS.register("sfm", SocialForce)
GROUP_BEHAVIORS.register("orca", OrcaGroup)
GROUP_BEHAVIORS.register("sfm", SocialForceGroup)
