"""fmcw_lidar2d: a planar scan of ranges and radial velocities."""

from typing import Any

import numpy as np

from irsim_gym.base.options import defaults, kind, option
from irsim_gym.bodies.sensors import hits, reports, scanning
from irsim_gym.simulator.world.names import Group, Model, Outline, Shard, State


@kind
class FmcwPlot:
    """Drawing options of a scanner with radial velocities; defaults come from the sensor's options."""

    alpha: float | None = option(None, ge=0.0, le=1.0, meaning="Opacity of beams that hit; default: the sensor's.")
    color: str | None = option(None, min_length=1, meaning="Colour without velocity_color; default: the sensor's.")
    velocity_color: bool = option(True, meaning="Colour the beams by their radial velocity.")
    velocity_color_max: float = option(2.0, gt=0.0, unit="m/s", meaning="Speed with the full colour.")
    velocity_linewidth: float = option(1.2, ge=0.0, unit="point", meaning="Line width of beams that hit.")
    no_hit_linewidth: float = option(0.8, ge=0.0, unit="point", meaning="Line width of other beams.")
    no_hit_alpha: float = option(0.1, ge=0.0, le=1.0, meaning="Opacity of other beams.")
    show_velocity_markers: bool = option(True, meaning="Mark the points that beams hit.")
    velocity_marker_size: float = option(12.0, ge=0.0, unit="point^2", meaning="Area of these marks.")
    velocity_marker_edge_color: str = option("black", min_length=1, meaning="Edge colour of these marks.")
    velocity_marker_edge_width: float = option(0.4, ge=0.0, unit="point", meaning="Edge width of these marks.")
    zero_velocity_color: str = option("#56B4E9", min_length=1, meaning="Colour for zero velocity.")
    positive_velocity_color: str = option("#CC3311", min_length=1, meaning="Colour for increasing range.")
    negative_velocity_color: str = option("#0072B2", min_length=1, meaning="Colour for decreasing range.")
    no_hit_color: str = option("lightgray", min_length=1, meaning="Colour of other beams.")


@kind
class FmcwLidar2D(scanning.RangeSensor):
    """A scanner that measures the range of each beam and its rate of change.

    A positive radial velocity points away from the sensor. It is relative to the sensor, or, with
    ``motion_compensate``, to the ground.
    """

    velocity_noise_std: float = option(0.0, ge=0.0, unit="m/s", meaning="Noise of velocities, also with noise: false.")
    motion_compensate: bool = option(False, meaning="Subtract the sensor's own motion from the velocities.")
    alpha: float | None = option(None, ge=0.0, le=1.0, meaning="Opacity of hits; default: 1, without colours 0.3.")
    color: str = option("#F97316", min_length=1, meaning="Colour of the beams without velocity_color.")
    plot: FmcwPlot = option(defaults(FmcwPlot), meaning="Drawing options of the sensor.")

    def group_key(self) -> tuple[Any, ...]:
        """Return the properties that members of one group share: the beams, and whether they are noisy."""
        return self.number, scanning.sweep(self), self.noise

    @staticmethod
    def prepare(group: Group, outlines: list[Outline], model: Model, n_slots: int) -> None:
        """Allocate the arrays of ``scanning.prepare``, and ``radial_velocity`` [m/s], shaped as ``ranges``."""
        scanning.prepare(group, outlines, model, n_slots, finds_hits=True)
        group.arrays["radial_velocity"] = np.zeros(group.arrays["ranges"].shape)

    @staticmethod
    def sense(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' ranges and radial velocities."""
        scanning.scan(group, model, state, shard)
        velocity = group.arrays["radial_velocity"]
        hits.write_radial_velocity(shard.worlds, group.params, group.tables, state, velocity)

    @staticmethod
    def report(group: Group, member: int, world: int) -> dict[str, Any]:
        """Return a copy of the scan under IR-SIM's names; ``radial_velocity`` [m/s] has shape ``(n_beams,)``."""
        report, speeds = reports.scan_report(group, member, world), group.arrays["radial_velocity"][world, member]
        return {**report, "radial_velocity": speeds.copy(), "valid": reports.is_valid(group, member, world)}
