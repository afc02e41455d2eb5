"""A range sensor without beams, for learners that have none: it has shown nothing."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from irsim_gym.simulator.world.group import Group
from irsim_gym.tasks.terms import Floats, Ints, Simulation


@dataclass(frozen=True)
class BlindSensor:
    """A mount without beams, in the words of a ``lidar2d``."""

    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    range_min: float = 0.0
    range_max: float = float(np.finfo(np.float32).max)

    def angles(self) -> Floats:
        """Return the directions of no beams."""
        return np.zeros(0)


def blind_sensors(simulation: Simulation, agents: Ints) -> tuple[Group, Ints]:
    """Return a group of sensors without beams, and each agent's member of it. They are no part of the simulation."""
    n = len(agents)
    ranges, footprint = np.zeros((simulation.n_worlds, n, 0), np.float32), np.zeros((n, 0), np.float32)
    arrays: dict[str, Any] = {"angles": BlindSensor().angles(), "ranges": ranges, "footprint": footprint}
    return Group(BlindSensor, [BlindSensor()] * n, agents, arrays=arrays), np.arange(n)
