"""radius: a round robot that is larger or smaller than its entry says."""

from typing import Annotated, ClassVar

import numpy as np

from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State, kernel, kind, mix, option, uniform

LEAST_SIZE = 1e-3
"""Lower bound of true radii [m]."""


@kind
class Radius:
    """A round robot has another radius than its entry says, which its observations of itself tell all the same."""

    acts_on: ClassVar[str] = "outline"

    offset: Annotated[Drawn, Bounds(-100.0, 100.0)] = option(0.0, unit="m", meaning="True radius less the entry's.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Note the radii of the entries."""
        group.arrays["told"] = model.local_discs[0, model.disc_start[group.members], 2].copy()

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write true radii."""
        resize(shard.worlds, group.tables, group.arrays["told"], model)


@kernel
def resize(worlds: Ints, disturbed: Disturbed, told: Floats, model: Model) -> None:
    """Draw radii, from streams of their own: the level is placed afterwards, with these.

    Reads: disturbed (high, keys, low, members, random), model (disc_start, level_stream, local_discs).
    Writes: disturbed (random), model (local_discs, reach).
    """
    for w in worlds:
        for k in range(disturbed.members.shape[0]):
            disc = model.local_discs[w, model.disc_start[disturbed.members[k]]]
            disturbed.random[w, k] = mix(model.level_stream[w] ^ disturbed.keys[k])
            offset = uniform(disturbed.random[w], k, disturbed.low[k, 0], disturbed.high[k, 0])
            disc[2] = max(told[k] + offset, LEAST_SIZE)
            model.reach[w, disturbed.members[k]] = np.sqrt(disc[0] * disc[0] + disc[1] * disc[1]) + disc[2]
