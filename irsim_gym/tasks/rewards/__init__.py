"""What is rewarded.

One file for each reward, named as in YAML; those of bodies that are pushed in ``pushing``.
"""

from irsim_gym.base.families import REWARDS
from irsim_gym.tasks.rewards.arrival import Arrival
from irsim_gym.tasks.rewards.clearance import Clearance
from irsim_gym.tasks.rewards.collision import Collision
from irsim_gym.tasks.rewards.deadlock import Deadlock
from irsim_gym.tasks.rewards.left_world import LeftWorldPenalty
from irsim_gym.tasks.rewards.obstruction import Obstruction
from irsim_gym.tasks.rewards.progress import Progress
from irsim_gym.tasks.rewards.pushing.body_arrival import BodyArrival
from irsim_gym.tasks.rewards.pushing.body_progress import BodyProgress
from irsim_gym.tasks.rewards.pushing.push_effort import PushEffort
from irsim_gym.tasks.rewards.smoothness import Smoothness
from irsim_gym.tasks.rewards.time import Time

REWARDS.register("progress", Progress)
REWARDS.register("arrival", Arrival)
REWARDS.register("collision", Collision)
REWARDS.register("deadlock", Deadlock)
REWARDS.register("left_world", LeftWorldPenalty)
REWARDS.register("time", Time)
REWARDS.register("clearance", Clearance)
REWARDS.register("obstruction", Obstruction)
REWARDS.register("smoothness", Smoothness)
REWARDS.register("body_progress", BodyProgress)
REWARDS.register("body_arrival", BodyArrival)
REWARDS.register("push_effort", PushEffort)
