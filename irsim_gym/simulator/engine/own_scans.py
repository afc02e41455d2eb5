"""Finds the range sensors of bodies whose behaviour reads its own scan (``reads_scan``)."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from irsim_gym.simulator.world.names import Group, Ints, OwnScan, find_sensor

RANGES = "ranges"
"""Name of the readings of range sensors."""


def with_scans(group: Group, bodies: Sequence[object], sensors: Sequence[Group]) -> list[Group]:
    """Split a group that decides into groups whose members read sensors of one group each.

    Members whose options read no scan form a group, too. A member without a range sensor, which must be one that cannot
    move, joins the first of the other groups.

    Args:
        group: A group whose kind has not prepared anything yet; it comes back as it is if nobody in it reads scans.
        bodies: What the file says of each body.
        sensors: The groups of sensors, with their readings.
    """
    reads = np.array([getattr(options, "reads_scan", False) for options in group.options], np.bool_)
    if not reads.any():
        return [group]
    if not reads.all():
        blind, rest = (_part(group, np.flatnonzero(chosen)) for chosen in (~reads, reads))
        return [blind, *with_scans(rest, bodies, sensors)]
    pairs = [find_sensor(bodies, sensors, b, RANGES) for b in group.members.tolist()]
    # Distinct groups of sensors, in the order of members; ``place`` numbers each member's group among them.
    groups = list({id(item[0]): item[0] for item in pairs if item is not None}.values())
    numbers = np.array([-1 if item is None else item[1] for item in pairs], np.int64)
    place = np.array([0 if item is None else groups.index(item[0]) for item in pairs], np.int64)
    parts = [np.flatnonzero(place == i) for i in range(len(groups))]
    return [_part(group, part, own_scan(scanners, numbers[part])) for part, scanners in zip(parts, groups, strict=True)]


def _part(group: Group, chosen: Ints, scan: OwnScan | None = None) -> Group:
    """Return some members of a group, perhaps with their scans, as a group of its own."""
    return Group(group.kind, [group.options[k] for k in chosen], group.members[chosen], names=group.names, scan=scan)


def own_scan(sensors: Group, members: Ints) -> OwnScan:
    """Return the scans that some members of a group of range sensors write."""
    offset = np.array([getattr(sensor, "offset", (0.0, 0.0, 0.0)) for sensor in sensors.options], np.float64)
    angles = np.array([sensor.angles() for sensor in sensors.options], np.float64) + offset[:, 2:]
    near = np.array([getattr(sensor, "range_min", 0.0) for sensor in sensors.options], np.float64)
    far = np.array([getattr(sensor, "range_max", np.inf) for sensor in sensors.options], np.float64)
    std = [getattr(sensor, "std", 0.0) if getattr(sensor, "noise", False) else 0.0 for sensor in sensors.options]
    scan: dict[str, Any] = {"ranges": sensors.arrays[RANGES], "angles": angles, "offset": offset}
    beams = {"beams_x": np.cos(angles), "beams_y": np.sin(angles), "range_min": near, "range_max": far}
    return OwnScan(sensors=members, noise=np.array(std, np.float64), **scan, **beams)
