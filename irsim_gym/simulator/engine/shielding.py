"""The shield of the learners: what stands between their commands and their drives."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from irsim_gym.simulator.engine.own_scans import RANGES, own_scan
from irsim_gym.simulator.engine.simulation import Simulation
from irsim_gym.simulator.world.names import Group, Ints, Shard, find_sensor
from irsim_gym.simulator.world.response import Response, respond_at_once


@dataclass
class Shielding:
    """A shield for the agents of a simulation.

    Attributes:
        groups: The agents, one group for each group of sensors.
        disturbances: What makes commands act late or slowly.
        response: How the agents respond to commands.
        acted: Whether it changed the latest command, 0 or 1, shape ``(n_worlds, n_agents)``.
    """

    groups: list[Group]
    disturbances: list[Group]
    response: Response
    acted: Ints

    def act(self, simulation: Simulation, shard: Shard) -> None:
        """Change the agents' commands where they are not safe."""
        respond_at_once(shard.worlds, self.response, self.acted)
        for group in self.disturbances:
            group.kind.foresee(group, simulation.model, self.response, shard)
        for group in self.groups:
            group.kind.shield(group, simulation.model, simulation.state, shard)


def lay_shield(simulation: Simulation, options: Any, agents: Ints) -> Shielding:
    """Return the shield of some agents, each of which has a range sensor.

    Args:
        simulation: The worlds.
        options: Instance of a registered shield.
        agents: Body of each agent, shape ``(n_agents,)``.
    """
    parts, bodies, shape = simulation.parts, simulation.scenario.bodies, (simulation.n_worlds, len(agents))
    disturbances = [group for turn in parts.turns for group in turn.commands if hasattr(group.kind, "foresee")]
    queues = [group.arrays["queue"] for group in disturbances if "queue" in group.arrays]
    place = np.full(len(bodies), -1, np.int64)
    place[agents] = np.arange(len(agents))
    pending = np.zeros((*shape, sum(queue.shape[1] * queue.shape[2] for queue in queues), 3))
    response = Response(place, pending, np.zeros(shape, np.int64), np.ones(shape), np.zeros(shape))
    shielding = Shielding([], disturbances, response, np.zeros(shape, np.int64))
    sensors = [find_sensor(bodies, parts.sensors, b, RANGES) for b in agents.tolist()]
    for scanners in parts.sensors:
        chosen = [(b, one[1]) for b, one in zip(agents.tolist(), sensors, strict=True) if one and one[0] is scanners]
        if chosen:
            members, numbers = np.array(chosen, np.int64).T.copy()
            group = Group(type(options), [options] * len(chosen), members, scan=own_scan(scanners, numbers))
            group.context, group.arrays["acted"] = simulation.context, shielding.acted
            group.kind.prepare(group, response, simulation.model, simulation.shards.n_slots)
            shielding.groups.append(group)
    return shielding
