"""The tables of shields for kernels."""

from dataclasses import dataclass

import numpy as np

from irsim_gym.bodies.behaviors.shared.steering import commanded_by_rate
from irsim_gym.simulator.world.names import Flags, Floats, Group, Ints, OwnScan, Struct
from irsim_gym.simulator.world.response import Response

WALLS_OF_A_PAIR = 3
"""Lines between two neighbouring beams at most, see ``walls.lay_walls``."""


@dataclass(repr=False)
class ShieldTables(Struct):
    """The members of a shield. Arrays with a slot are scratch memory, one row for each shard.

    Attributes:
        members: Body of each member, shape ``(n_members,)``.
        margin: Distance that it keeps from what it sees [m], shape ``(n_members,)``.
        horizon: How far ahead others' ways are followed [s], likewise; 0 for a shield that follows none.
        by_rate: The second number of an Ackermann drive's command is a turn rate, shape ``(n_members,)``.
        scan: What the members see.
        response: How bodies respond to commands.
        command: The command that is tried [m/s or rad/s], shape ``(n_slots, 3)``.
        now: The velocity on the way that a command leads to, likewise.
        place: The pose there, and the steering angle [m, m, rad, rad], shape ``(n_slots, 4)``.
        walls: What stands nearby: x0, y0, x1, y1 in the body frame [m], shape ``(n_slots, n + 1, 4)``.
        need: Distance that has to remain to each of them [m], shape ``(n_slots, n)``.
        acted: Whether a learner's command was changed, 0 or 1, shape ``(n_worlds, n_agents)``.
    """

    members: Ints
    margin: Floats
    horizon: Floats
    by_rate: Flags
    scan: OwnScan
    response: Response
    command: Floats
    now: Floats
    place: Floats
    walls: Floats
    need: Floats
    acted: Ints


def lay_tables(group: Group, response: Response, n_slots: int) -> ShieldTables:
    """Return the tables of a shield's members.

    Args:
        group: The members.
        response: How bodies respond to commands.
        n_slots: Number of shards.
    """
    n_walls = WALLS_OF_A_PAIR * group.scan.ranges.shape[2]
    return ShieldTables(
        members=group.members,
        margin=np.array([option.margin for option in group.options], np.float64),
        horizon=np.array([getattr(option, "horizon", 0.0) for option in group.options], np.float64),
        by_rate=commanded_by_rate(group),
        scan=group.scan,
        response=response,
        command=np.zeros((n_slots, 3)),
        now=np.zeros((n_slots, 3)),
        place=np.zeros((n_slots, 4)),
        walls=np.zeros((n_slots, n_walls + 1, 4)),
        need=np.zeros((n_slots, n_walls)),
        acted=group.arrays["acted"],
    )
