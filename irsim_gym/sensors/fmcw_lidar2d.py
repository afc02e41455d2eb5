"""fmcw_lidar2d: a scan of ranges and radial velocities. Its options are known; it does not run yet."""

from __future__ import annotations

import math
from typing import Any

from irsim_gym.scenario.options import kind, option


@kind
class FmcwLidar2D:
    """A scanner that measures, along each beam, the range and the speed at which it changes."""

    number: int = option(100, ge=1, le=100_000, meaning="Number of beams.")
    angle_range: float = option(math.pi, ge=0.0, unit="rad", meaning="Angle between first and last beam; at most 2 pi.")
    range_min: float = option(0.0, ge=0.0, unit="m", meaning="Shorter ranges are reported as this.")
    range_max: float = option(10.0, gt=0.0, unit="m", meaning="Farther things are not seen; a free beam reports this.")
    scan_time: float = option(0.1, gt=0.0, unit="s", meaning="Duration of a scan; reported only.")
    noise: bool = option(False, meaning="Add noise to the ranges.")
    std: float = option(0.2, ge=0.0, unit="m", meaning="Standard deviation of the range noise.")
    angle_std: float = option(0.02, ge=0.0, unit="rad", meaning="Standard deviation of the beams' directions.")
    offset: tuple[float, float, float] = option(
        (0.0, 0.0, 0.0), unit="m, m, rad", meaning="Mount pose in the body frame."
    )
    alpha: float = option(0.3, ge=0.0, le=1.0, meaning="Opacity of the drawn beams.")
    color: str = option("#CC3311", meaning="Colour of the drawn beams.")
    motion_compensate: bool = option(False, meaning="Take the sensor's own motion out of the speeds.")
    plot: Any = option(None, meaning="Drawing options of the sensor.")
