"""range_bias: ranges that are too long or too short."""

from typing import Annotated, ClassVar

import numpy as np

from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.names import Group, Ints, Model, OwnScan, Rays, Shard, State, kernel, kind, option

Limits = tuple[np.float32, np.float32]
"""Least and greatest range of a sensor [m]."""


@kind
class RangeBias:
    """Each range r of a beam that hits something reads r (1 + scale) + offset, between range_min and range_max."""

    acts_on: ClassVar[str] = "scan"

    offset: Annotated[Drawn, Bounds(-100.0, 100.0)] = option(0.0, unit="m", meaning="Added to each range.")
    scale: Annotated[Drawn, Bounds(-1.0, 10.0)] = option(0.0, meaning="Share by which each range is too long.")

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Change the ranges."""
        add_bias(shard.worlds, group.tables, group.scan)


@kernel
def add_bias(worlds: Ints, disturbed: Disturbed, scan: OwnScan) -> None:
    """Scale and shift the ranges below range_max.

    Reads: disturbed (values), scan (range_max, range_min, ranges, sensors).
    Writes: scan (ranges).
    """
    for w in worlds:
        for k in range(scan.sensors.shape[0]):
            s = scan.sensors[k]
            least, most = np.float32(scan.range_min[s]), np.float32(scan.range_max[s])
            offset, factor = np.float32(disturbed.values[w, k, 0]), np.float32(1.0 + disturbed.values[w, k, 1])
            shift_ranges(scan.ranges[w, s], factor, offset, (least, most))


@kernel
def shift_ranges(ranges: Rays, factor: np.float32, offset: np.float32, limits: Limits) -> None:
    """Scale and shift the ranges of a scan; without branches, so that the loop is vectorised."""
    least, most = limits
    for i in range(ranges.shape[0]):
        read = ranges[i] * factor + offset
        read = least if read < least else read
        read = read if read < most else most
        ranges[i] = read if ranges[i] < most else most
