"""What environments return when they are asked: their numbers with meanings, and the present of their worlds."""

from irsim_gym.envs.described.description import Description
from irsim_gym.envs.described.moment import Bodies, BodyMoment, WorldMoment
from irsim_gym.envs.described.parts import Action, Block, Component, Ending, Info, Part, Reward
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.envs.parts.mirror import Mirror
from irsim_gym.simulator.readings.body_readings import BodyReadings

__all__ = ["Action", "Block", "Bodies", "BodyMoment", "BodyReadings", "Component", "Description", "Ending", "Info"]
__all__ += ["Mirror", "Part", "Reward", "WorldMoment", "Worlds"]
