"""lost_beams: beams without a reading."""

from typing import Annotated, ClassVar, Literal

import numpy as np

from irsim_gym.base.arraytypes import Rays
from irsim_gym.base.options import Bounds, Drawn, drawn_problems
from irsim_gym.base.rng import next_bits
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.names import Group, Ints, Model, Shard, State, kernel, kind, option
from irsim_gym.simulator.world.own_scan import OwnScan

TWO_32 = 2.0**32


@kind
class LostBeams:
    """In each scan some beams are lost, each by itself."""

    acts_on: ClassVar[str] = "scan"

    chance: Annotated[Drawn, Bounds(0.0, 1.0)] = option(0.0, meaning="Probability, in each scan, that a beam is lost.")
    reads: Literal["none", "zero"] = option(
        "none", meaning="What a lost beam reads: range_max, as if nothing were there (none), or range_min (zero)."
    )

    problems = drawn_problems

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Note what each member's lost beams read."""
        scan: OwnScan = group.scan
        zero = np.array([one.reads == "zero" for one in group.options], np.bool_)
        reading = np.where(zero, scan.range_min[scan.sensors], scan.range_max[scan.sensors])
        group.arrays["reading"] = reading.astype(np.float32)

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Overwrite the ranges of lost beams."""
        lose_beams(shard.worlds, group.tables, group.scan, group.arrays["reading"])


@kernel
def lose_beams(worlds: Ints, disturbed: Disturbed, scan: OwnScan, reading: Rays) -> None:
    """Overwrite the ranges of beams whose random number is too small.

    Reads: disturbed (random, values), scan (ranges, sensors), reading.
    Writes: disturbed (random), scan (ranges).
    """
    for w in worlds:
        for k in range(scan.sensors.shape[0]):
            bits = next_bits(disturbed.random[w], k)
            threshold = np.uint64(disturbed.values[w, k, 0] * TWO_32)
            overwrite_some(scan.ranges[w, scan.sensors[k]], reading[k], bits, threshold)


@kernel
def overwrite_some(ranges: Rays, reading: np.float32, bits: np.uint64, threshold: np.uint64) -> None:
    """Overwrite each range with the probability ``threshold`` / 2^32.

    The random numbers are a hash of the beam's number (the finaliser of MurmurHash3, in 32 bits): beams need no
    numbers of those before them, so that the loop is vectorised.
    """
    first = np.uint32(bits)
    for i in range(ranges.shape[0]):
        x = np.uint32(np.uint32(i) * np.uint32(0x9E3779B1) + first)
        x = np.uint32((x ^ (x >> np.uint32(16))) * np.uint32(0x85EBCA6B))
        x = np.uint32((x ^ (x >> np.uint32(13))) * np.uint32(0xC2B2AE35))
        x = np.uint32(x ^ (x >> np.uint32(16)))
        ranges[i] = reading if np.uint64(x) < threshold else ranges[i]
