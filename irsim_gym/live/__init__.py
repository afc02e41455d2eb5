"""Worlds that scripts step, as in IR-SIM, in the same simulator."""

from irsim_gym.live.body import Body
from irsim_gym.live.plan_ways import plan
from irsim_gym.live.world import World, load

__all__ = ["Body", "World", "load", "plan"]
