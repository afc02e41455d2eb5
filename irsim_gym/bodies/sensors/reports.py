"""Reports of scans in IR-SIM's form: dictionaries and points."""

from typing import Any

import numpy as np

from irsim_gym.simulator.world.names import Flags, Floats, Group

FREE_MARGIN = 0.02
"""Points nearer than this to range_max are omitted [m]."""


def scan_report(group: Group, member: int, world: int) -> dict[str, Any]:
    """Return the report of a range sensor under IR-SIM's names, with copies of the arrays.

    Angles are in the sensor frame [rad]; ``ranges`` [m] has shape ``(n_beams,)``. The scan is instantaneous, so
    ``time_increment`` [s] is 0.
    """
    options, angles = group.options[member], group.arrays["angles"]
    step = float(angles[-1] - angles[0]) / max(len(angles) - 1, 1)
    fan = {"angle_min": float(angles[0]), "angle_max": float(angles[-1]), "angle_increment": step}
    seen = {"range_min": options.range_min, "range_max": options.range_max, "ranges": read_ranges(group, member, world)}
    return {**fan, "time_increment": 0.0, "scan_time": options.scan_time, **seen, "intensities": None}


def read_ranges(group: Group, member: int, world: int) -> Floats:
    """Return a copy of the ranges [m], shape ``(n_beams,)``, with range_min and range_max exactly as in the options."""
    options, measured = group.options[member], group.arrays["ranges"][world, member]
    ranges: Floats = measured.astype(np.float64)
    ranges[measured <= np.float32(options.range_min)] = options.range_min
    ranges[measured >= np.float32(options.range_max)] = options.range_max
    return ranges


def is_valid(group: Group, member: int, world: int) -> Flags:
    """Return which beams hit something between range_min and range_max, shape ``(n_beams,)``.

    A free beam reads range_max. What is closer than range_min, also because of noise, reads range_min.
    """
    options, ranges = group.options[member], group.arrays["ranges"][world, member]
    valid: Flags = (ranges > np.float32(options.range_min)) & (ranges < np.float32(options.range_max))
    return valid


def scan_points(group: Group, member: int, world: int) -> Floats | None:
    """Return the points of valid beams in the sensor frame [m], shape ``(2, n_points)``; None without any.

    They lie in the nominal directions. Those within 0.02 m of range_max are left out, as in IR-SIM.
    """
    ranges = read_ranges(group, member, world)
    chosen = is_valid(group, member, world) & (ranges < group.options[member].range_max - FREE_MARGIN)
    if not chosen.any():
        return None
    angles, ranges = group.arrays["angles"][chosen], ranges[chosen]
    return np.stack([ranges * np.cos(angles), ranges * np.sin(angles)])
