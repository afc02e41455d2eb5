"""scan_rate: a sensor that is slower than the steps."""

from typing import Annotated, ClassVar

import numpy as np

from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.simulator.world.disturbed import Disturbed, whole_steps
from irsim_gym.simulator.world.names import Group, Ints, Model, OwnScan, Rays, Shard, State, kernel, kind, option


@kind
class ScanRate:
    """The sensor measures at the start and then at intervals; in between its last scan stays."""

    acts_on: ClassVar[str] = "scan"

    every: Annotated[Drawn, Bounds(0.0, 100.0)] = option(0.0, unit="s", meaning="Time between scans, in whole steps.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Make room for the last scans."""
        group.arrays["held"] = np.zeros((*group.tables.count.shape, group.scan.ranges.shape[2]), np.float32)

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Replace new scans by the last ones that were due."""
        hold_scans(shard.worlds, group.tables, group.scan, group.arrays["held"], model)


@kernel
def hold_scans(worlds: Ints, disturbed: Disturbed, scan: OwnScan, held: Rays, model: Model) -> None:
    """Keep scans that are due, and put the last kept ones in place of the others.

    Reads: disturbed (count, values), scan (ranges, sensors), model (step_time).
    Writes: disturbed (count), scan (ranges), held.
    """
    for w in worlds:
        for k in range(scan.sensors.shape[0]):
            every = max(whole_steps(disturbed.values[w, k, 0], model.step_time[0]), 1)
            is_due, ranges = disturbed.count[w, k] % every == 0, scan.ranges[w, scan.sensors[k]]
            disturbed.count[w, k] += 1
            for i in range(ranges.shape[0]):
                if is_due:
                    held[w, k, i] = ranges[i]
                ranges[i] = held[w, k, i]
