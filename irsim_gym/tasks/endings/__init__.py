"""The endings of episodes; the time limit is part of ``Episodes``."""

from irsim_gym.families import ENDINGS
from irsim_gym.tasks.endings.arrived import Arrived
from irsim_gym.tasks.endings.collided import Collided
from irsim_gym.tasks.endings.deadlocked import Deadlocked
from irsim_gym.tasks.endings.left_world import LeftWorld

ENDINGS.register("arrived", Arrived)
ENDINGS.register("collided", Collided)
ENDINGS.register("deadlocked", Deadlocked)
ENDINGS.register("left_world", LeftWorld)
