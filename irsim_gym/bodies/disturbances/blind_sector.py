"""blind_sector: directions in which a sensor sees nothing."""

from typing import Annotated, ClassVar

import numpy as np

from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.simulator.geometry.angles import wrap
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.names import Flags, Group, Ints, Model, Shard, State, kernel, kind, option, uniform
from irsim_gym.simulator.world.own_scan import OwnScan

FULL_TURN = 2.0 * np.pi


@kind
class BlindSector:
    """Beams in a sector around a direction that each level draws read range_max, as if nothing were there."""

    acts_on: ClassVar[str] = "scan"

    width: Annotated[Drawn, Bounds(0.0, FULL_TURN)] = option(0.0, unit="rad", meaning="Angle of the sector.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Make room for marks of the beams in the sector."""
        group.arrays["blind"] = np.zeros((*group.tables.count.shape, group.scan.ranges.shape[2]), np.bool_)

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Overwrite the ranges of the sector."""
        hide_sector(shard.worlds, group.tables, group.scan, group.arrays["blind"])


@kernel
def hide_sector(worlds: Ints, disturbed: Disturbed, scan: OwnScan, blind: Flags) -> None:
    """Overwrite the ranges of beams in the sector, which is drawn in the first scan.

    Reads: disturbed (count, random, values), scan (angles, range_max, sensors).
    Writes: disturbed (count, random), scan (ranges), blind.
    """
    for w in worlds:
        for k in range(scan.sensors.shape[0]):
            s = scan.sensors[k]
            if disturbed.count[w, k] == 0:
                middle = uniform(disturbed.random[w], k, -np.pi, np.pi)
                for i in range(blind.shape[2]):
                    blind[w, k, i] = np.abs(wrap(scan.angles[s, i] - middle)) < 0.5 * disturbed.values[w, k, 0]
            disturbed.count[w, k] += 1
            for i in range(blind.shape[2]):
                if blind[w, k, i]:
                    scan.ranges[w, s, i] = scan.range_max[s]
