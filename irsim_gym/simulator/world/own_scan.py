"""The scans of the bodies that decide, for behaviours that read them."""

import dataclasses
from dataclasses import dataclass
from typing import Self

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Rays
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import Struct


@dataclass(repr=False)
class OwnScan(Struct):
    """The latest scan of each member of a group that decides: that of the member's first range sensor.

    Member k has the sensor number ``s = sensors[k]``, and its scan in world w is ``ranges[w, s]``. All sensors of a
    group have as many beams. Kernels only read.

    Attributes:
        sensors: Number of each member's sensor, -1 for one of a group that has none and cannot move; shape
            ``(n_members,)``.
        ranges: The readings [m], shape ``(n_worlds, n_sensors, n_beams)``; ``range_max`` where a beam hits nothing.
        angles: Nominal directions of the beams in the body frame [rad], shape ``(n_sensors, n_beams)``.
        beams_x: Cosines of ``angles``, likewise.
        beams_y: Sines of ``angles``, likewise.
        offset: Mount poses in the body frame [m, m, rad], shape ``(n_sensors, 3)``.
        range_min: Readings up to this are not valid [m], shape ``(n_sensors,)``.
        range_max: Range of a beam that hits nothing [m], shape ``(n_sensors,)``.
        noise: Standard deviation of the readings as the file says [m], shape ``(n_sensors,)``.
    """

    sensors: Ints
    ranges: Rays
    angles: Floats
    beams_x: Floats
    beams_y: Floats
    offset: Floats
    range_min: Floats
    range_max: Floats
    noise: Floats

    def select(self, chosen: Ints) -> Self:
        """Return the scans of some of the members, by their numbers.

        Args:
            chosen: Numbers of the members, shape ``(n,)``.
        """
        return dataclasses.replace(self, sensors=self.sensors[chosen])


@kernel
def find_hits(scan: OwnScan, w: int, k: int, limit: float, points: Floats) -> int:
    """Write the points that the beams of member k in world w hit, and return their number.

    Beams count that end at most ``limit`` from the sensor, between ``range_min`` and ``range_max``.

    Reads: scan (beams_x, beams_y, offset, range_max, range_min, ranges, sensors).
    Writes: points.

    Args:
        scan: The scans.
        w: The world.
        k: The member.
        limit: Greatest distance from the sensor [m].
        points: Written: x and y in the body frame [m], shape ``(2, n_beams)`` at least.
    """
    s, count = scan.sensors[k], 0
    if s < 0:
        return 0
    x, y, ranges = scan.offset[s, 0], scan.offset[s, 1], scan.ranges[w, s]
    least, most = np.float32(scan.range_min[s]), np.float32(scan.range_max[s])
    for i in range(ranges.shape[0]):
        # Strictly between both: a range of range_max is a beam without a hit, one of range_min too near to be true.
        if least < ranges[i] < most and ranges[i] <= limit:
            points[0, count] = x + ranges[i] * scan.beams_x[s, i]
            points[1, count] = y + ranges[i] * scan.beams_y[s, i]
            count += 1
    return count
