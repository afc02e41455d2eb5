"""A world by hand: IR-SIM's way of running a file, on the same simulator."""

from irsim_gym.live.body import Body
from irsim_gym.live.plan_ways import plan
from irsim_gym.live.world import World, load

__all__ = ["Body", "World", "load", "plan"]
