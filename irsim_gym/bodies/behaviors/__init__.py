"""How a body decides.

One file, or one folder, for each behaviour, named as in YAML.
"""

from irsim_gym.base.families import BEHAVIORS, GROUP_BEHAVIORS
from irsim_gym.bodies.behaviors.dash import Dash
from irsim_gym.bodies.behaviors.hybrid_astar.hybrid_astar import HybridAstar
from irsim_gym.bodies.behaviors.local_planners.dwa import Dwa
from irsim_gym.bodies.behaviors.orca.orca import OrcaGroup
from irsim_gym.bodies.behaviors.pursuit.pursuit import Pursuit
from irsim_gym.bodies.behaviors.recorded import Recorded
from irsim_gym.bodies.behaviors.rvo.rvo import Rvo
from irsim_gym.bodies.behaviors.social_force.group import SocialForceGroup
from irsim_gym.bodies.behaviors.social_force.social_force import SocialForce

BEHAVIORS.register("dash", Dash)
BEHAVIORS.register("dwa", Dwa)
BEHAVIORS.register("hybrid_astar", HybridAstar)
BEHAVIORS.register("pursuit", Pursuit)
BEHAVIORS.register("recorded", Recorded)
BEHAVIORS.register("rvo", Rvo)
BEHAVIORS.register("sfm", SocialForce)
GROUP_BEHAVIORS.register("orca", OrcaGroup)
GROUP_BEHAVIORS.register("sfm", SocialForceGroup)
