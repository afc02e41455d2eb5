"""A scenario is compiled into a simulation, and a simulation is stepped.

YAML's vocabulary ends here.
"""

from irsim_gym.simulator.engine.compile import compile
from irsim_gym.simulator.engine.simulation import Simulation
from irsim_gym.simulator.world.group import Shard

__all__ = ["Shard", "Simulation", "compile"]
