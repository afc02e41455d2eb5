"""lost_beams: beams without a reading."""

import hashlib
from typing import Annotated, ClassVar, Literal

import numpy as np

from irsim_gym.base.arraytypes import Labels, Rays
from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.names import Group, Ints, Model, OwnScan, Shard, State, kernel, kind, next_bits, option

TWO_32, TWO_31 = 2.0**32, 2**31
PLACES = 4096
HIGH, LOW = np.uint64(64 - 12), np.uint64(2**32 - 1)
"""Bits of a random number that choose one of ``PLACES``, and those that shift."""


@kind
class LostBeams:
    """In each scan some beams are lost, each by itself."""

    acts_on: ClassVar[str] = "scan"

    chance: Annotated[Drawn, Bounds(0.0, 1.0)] = option(0.0, meaning="Probability, in each scan, that a beam is lost.")
    reads: Literal["none", "zero"] = option("none", meaning="A lost beam reads range_max (none) or range_min (zero).")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Note what each member's lost beams read."""
        scan: OwnScan = group.scan
        zero = np.array([option.reads == "zero" for option in group.options], np.bool_)
        reading = np.where(zero, scan.range_min[scan.sensors], scan.range_max[scan.sensors])
        group.arrays["reading"] = reading.astype(np.float32)
        # Each scan takes random numbers from a random place of this table on, and adds a random number to all of them:
        # to draw one for each beam would take several times as long as the beams' other disturbances together.
        noise = hashlib.shake_128(b"lost_beams").digest(4 * (PLACES + scan.ranges.shape[2]))
        group.arrays["numbers"] = np.frombuffer(noise, "<i4").astype(np.int32)

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Overwrite the ranges of lost beams."""
        lose_beams(shard.worlds, group.tables, group.scan, group.arrays["reading"], group.arrays["numbers"])


@kernel
def lose_beams(worlds: Ints, disturbed: Disturbed, scan: OwnScan, reading: Rays, numbers: Labels) -> None:
    """Overwrite the ranges of beams whose random number is too small.

    Reads: disturbed (random, values), scan (ranges, sensors).
    Writes: disturbed (random), scan (ranges).
    """
    for w in worlds:
        for k in range(scan.sensors.shape[0]):
            bits, count = next_bits(disturbed.random[w], k), np.int64(disturbed.values[w, k, 0] * TWO_32)
            if count > 0:
                first, ranges = np.int64(bits >> HIGH), scan.ranges[w, scan.sensors[k]]
                chosen = numbers[first : first + ranges.shape[0]]
                # Signed numbers, from -2^31 on: the processor compares vectors of these at once.
                overwrite_some(ranges, reading[k], chosen, np.int32(bits & LOW), np.int32(count - 1 - TWO_31))


@kernel
def overwrite_some(ranges: Rays, reading: np.float32, numbers: Labels, shift: np.int32, most: np.int32) -> None:
    """Overwrite each range whose number, shifted, is at most ``most``; without branches, so that it is vectorised."""
    for i in range(ranges.shape[0]):
        ranges[i] = reading if np.int32(numbers[i] + shift) <= most else ranges[i]
