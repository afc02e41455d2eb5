"""lidar2d: a planar scan of ranges."""

from typing import Any

import numpy as np

from irsim_gym.bodies.sensors import hits, reports, scanning
from irsim_gym.simulator.world.names import Group, Model, Outline, Shard, State, kind, option


@kind
class LidarPlot:
    """Drawing options of a range sensor; defaults come from the sensor's options."""

    alpha: float | None = option(None, ge=0.0, le=1.0, meaning="Opacity of the beams; default: the sensor's.")
    color: str | None = option(None, min_length=1, meaning="Colour of the beams; default: the sensor's.")


@kind
class Lidar2D(scanning.RangeSensor):
    """A scanner with ``number`` beams, evenly spaced over ``angle_range``, including both ends."""

    alpha: float = option(0.3, ge=0.0, le=1.0, meaning="Opacity of the drawn beams.")
    color: str = option("#F97316", min_length=1, meaning="Colour of the drawn beams.")
    has_velocity: bool = option(False, meaning="Report the velocity of what each beam hits, in the world frame.")
    plot: LidarPlot | None = option(None, meaning="Drawing options of the sensor.")

    def group_key(self) -> tuple[Any, ...]:
        """Return the properties that members of one group share: the beams, and the passes over them."""
        return self.number, scanning.sweep(self), self.noise, self.has_velocity

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
        scan = reports.scan_report(group, member, world)
        table = group.arrays
        still = np.zeros((2, len(scan["ranges"])))
        velocity = table["velocity"][world, member].copy() if "velocity" in table else still
        return {**scan, "velocity": velocity, "valid": reports.is_valid(group, member, world)}
