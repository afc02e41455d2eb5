"""A range sensor that hits nothing, for learners that have none."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.engine import Simulation
from irsim_gym.families import SENSORS
from irsim_gym.world.group import Group

N_BEAMS = 180
RANGE = 6.0


def blind_sensors(simulation: Simulation, agents: Ints) -> tuple[Group, Ints]:
    """Return a group of sensors whose beams always read their maximum range, and each agent's member of it.

    They are no part of the simulation: nothing writes their readings. Outlines count as discs of the agents' reach.
    """
    reach = simulation.model.reach[:, agents].max(axis=0)
    lidar = SENSORS.entry("lidar2d").kind(number=N_BEAMS, angle_range=2.0 * np.pi, range_max=RANGE)
    arrays = {
        "angles": lidar.angles(),
        "ranges": np.full((simulation.n_worlds, len(agents), N_BEAMS), RANGE, np.float32),
        "footprint": np.repeat(reach.astype(np.float32)[:, None], N_BEAMS, axis=1),
    }
    return Group(type(lidar), [lidar] * len(agents), agents, arrays=arrays), np.arange(len(agents))
