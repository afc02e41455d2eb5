"""When an episode ends.

One file for each ending, named as in YAML.
"""

from irsim_gym.base.families import ENDINGS
from irsim_gym.tasks.endings.arrived import Arrived
from irsim_gym.tasks.endings.bodies_arrived import BodiesArrived
from irsim_gym.tasks.endings.collided import Collided
from irsim_gym.tasks.endings.deadlocked import Deadlocked
from irsim_gym.tasks.endings.left_world import LeftWorld

ENDINGS.register("arrived", Arrived)
ENDINGS.register("collided", Collided)
ENDINGS.register("deadlocked", Deadlocked)
ENDINGS.register("left_world", LeftWorld)
ENDINGS.register("bodies_arrived", BodiesArrived)
