"""lidar2d: a planar scan of ranges."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from irsim_gym.sensors import hits, reports, scanning
from irsim_gym.world.names import Floats, Group, Model, Shard, State, kind, option
from irsim_gym.world.outline import Outline


@kind
class LidarPlot:
    """Drawing options of a range sensor; defaults come from the sensor's options."""

    alpha: float | None = option(None, ge=0.0, le=1.0, meaning="Opacity of the beams; default: the sensor's.")
    color: str | None = option(None, min_length=1, meaning="Colour of the beams; default: the sensor's.")


@kind
class Lidar2D:
    """A scanner with ``number`` beams, evenly spaced over ``angle_range``, including both ends."""

    reading: ClassVar[str] = "ranges"

    number: int = option(
        100,
        ge=1,
        le=100_000,
        meaning="Number of beams.",
        consequence="If large, steps take longer. If small, beams miss thin things.",
    )
    angle_range: float = option(
        np.pi,
        ge=0.0,
        unit="rad",
        meaning="Angle between first and last beam; at most 2 pi, where both look the same way.",
        consequence="Degrees instead of radians give a full turn.",
    )
    range_min: float = option(
        0.0, ge=0.0, unit="m", meaning="Shorter ranges are reported as this value and marked invalid."
    )
    range_max: float = option(10.0, gt=0.0, unit="m", meaning="Maximum range; a beam that hits nothing reports this.")
    scan_time: float = option(0.1, gt=0.0, unit="s", meaning="Duration of a scan; for information only.")
    noise: bool = option(False, meaning="Add noise to ranges and directions; beams that hit nothing keep their range.")
    std: float = option(
        0.2,
        ge=0.0,
        unit="m",
        meaning="Standard deviation of the range noise.",
        consequence="If as large as range_max, ranges are useless.",
    )
    angle_std: float = option(
        0.02,
        ge=0.0,
        unit="rad",
        meaning="With noise, standard deviation of the directions; reported angles do not change.",
    )
    offset: tuple[float, float, float] = option(
        (0.0, 0.0, 0.0), unit="m, m, rad", meaning="Mount pose in the body frame."
    )
    alpha: float = option(0.3, ge=0.0, le=1.0, meaning="Opacity of the drawn beams.")
    color: str = option("#F97316", min_length=1, meaning="Colour of the drawn beams.")
    has_velocity: bool = option(False, meaning="Report the velocity of what each beam hits, in the world frame.")
    plot: LidarPlot | None = option(None, meaning="Drawing options of the sensor.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from scanning.range_problems(self)

    def group_key(self) -> tuple[Any, ...]:
        """Return the properties that members of one group share: the beams, and the passes over them."""
        return self.number, scanning.sweep(self), self.noise, self.has_velocity

    def angles(self) -> Floats:
        """Return the beams' directions in the sensor frame [rad], shape ``(n_beams,)``; a single beam looks ahead."""
        return scanning.beam_angles(self)

    @staticmethod
    def prepare(group: Group, outlines: list[Outline], model: Model, n_slots: int) -> None:
        """Allocate the arrays of ``scanning.prepare`` and, with ``has_velocity``, the velocities of hit bodies.

        These are ``velocity`` [m/s] in the world frame, shape ``(n_worlds, n_members, 2, n_beams)``.
        """
        has_velocity = group.options[0].has_velocity
        scanning.prepare(group, outlines, model, n_slots, finds_hits=has_velocity)
        if has_velocity:
            n_worlds, n_members, n_beams = group.arrays["ranges"].shape
            group.arrays["velocity"] = np.zeros((n_worlds, n_members, 2, n_beams))

    @staticmethod
    def sense(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' ranges, and velocities if ``has_velocity``."""
        scanning.scan(group, model, state, shard)
        if group.options[0].has_velocity:
            hits.write_velocity(shard.worlds, group.tables, state, group.arrays["velocity"])

    @staticmethod
    def report(group: Group, member: int, world: int) -> dict[str, Any]:
        """Return a copy of the scan under IR-SIM's names; ``velocity`` [m/s] has shape ``(2, n_beams)``."""
        found = reports.scan_report(group, member, world)
        table = group.arrays
        still = np.zeros((2, len(found["ranges"])))
        velocity = table["velocity"][world, member].copy() if "velocity" in table else still
        return {**found, "velocity": velocity, "valid": reports.is_valid(group, member, world)}

    @staticmethod
    def points(group: Group, member: int, world: int) -> Floats | None:
        """Return the points that the beams hit, see ``reports.scan_points``."""
        return reports.scan_points(group, member, world)
