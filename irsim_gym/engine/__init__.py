"""Compiles scenarios into arrays, and steps them."""

from irsim_gym.engine.compile import compile
from irsim_gym.engine.simulation import Simulation
from irsim_gym.world.group import Shard

__all__ = ["Shard", "Simulation", "compile"]
