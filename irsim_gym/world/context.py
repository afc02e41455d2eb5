"""The bodies of a scenario beyond the arrays: what the file says of them, their sensors, their fields of view."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from irsim_gym.world.group import Group


@dataclass(frozen=True)
class WorldContext:
    """The bodies of a scenario, their sensors and their fields of view.

    Attributes:
        bodies: What the file says of each body.
        sensors: Groups of sensors with their readings.
        detect: Writes who is in a body's field of view, see ``engine.field_of_view``.
    """

    bodies: Sequence[Any]
    sensors: Sequence[Group]
    detect: Callable[..., None]


def find_sensor(
    bodies: Sequence[Any], sensors: Sequence[Group], body: int, reading: str, index: int = 0
) -> tuple[Group, int] | None:
    """Return the group and the member number of one of a body's sensors with some reading, None without it.

    Args:
        bodies: What the file says of each body.
        sensors: The groups of sensors.
        body: The body.
        reading: What the sensor reads, such as ``"ranges"``.
        index: Which of these sensors, in the order of the file.
    """
    wanted = [options for options in bodies[body].sensors if options.reading == reading]
    if not 0 <= index < len(wanted):
        return None
    for group in sensors:
        for k in map(int, np.flatnonzero(group.members == body)):
            if group.options[k] is wanted[index]:
                return group, k
    return None
