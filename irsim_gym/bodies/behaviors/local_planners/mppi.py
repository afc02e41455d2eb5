"""MPPI: model predictive path integral control (Williams et al. 2017) on the body's own scan."""

from typing import ClassVar

import numpy as np

from irsim_gym.bodies.behaviors.local_planners.mppi_sampling import Samples, decide_mppi, forget_plans
from irsim_gym.bodies.behaviors.local_planners.options import LocalPlanner
from irsim_gym.bodies.behaviors.local_planners.paths import find_paths
from irsim_gym.bodies.behaviors.local_planners.task import LocalTables
from irsim_gym.bodies.behaviors.local_planners.way import forget_ways
from irsim_gym.simulator.world.names import Group, Model, Shard, State, kind, option


@kind
class Mppi(LocalPlanner):
    """Plan the average of random command sequences around the previous plan, weighted by exp(-cost / temperature).

    The body sees what its first range sensor hits, and assumes that it stands still. Each sequence is simulated within
    the limits of the drive. Its cost is the integral over ``horizon`` [s] of
    ``goal_weight * g + path_weight * p + obstacle_weight * c``, with g, p and c as for ``dwa`` at each moment. Two of
    the sequences are not random: the previous plan, and a stop. The first command of the average is executed; the rest
    is the plan for the next decision. The noise comes from the world's random stream.
    """

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni", "acker")
    reads_neighbors: ClassVar[bool] = False
    reads_scan: ClassVar[bool] = True

    samples: int = option(
        200, ge=2, le=100_000, meaning="Number of sequences.", consequence="Computing time grows with it."
    )
    horizon: float = option(2.0, gt=0.0, le=60.0, unit="s", meaning="Duration of a sequence; in whole steps.")
    temperature: float = option(
        0.1, gt=0.0, unit="m s", meaning="A sequence that costs this much more than the best one has a weight of 1 / e."
    )
    noise: float = option(
        0.5,
        gt=0.0,
        meaning="Standard deviation of the noise, as a share of half the range of each number of a command.",
    )
    gamma: float = option(
        0.001, ge=0.0, unit="m s", meaning="Cost of noise in the direction of the planned command: gamma u e / s^2."
    )
    collision_cost: float = option(100.0, ge=0.0, unit="m s", meaning="Cost of a way that touches something.")
    obstacle_weight: float = option(0.005, ge=0.0, unit="m", meaning="Weight of the nearness of obstacles.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Allocate memory for the members' scans, paths, plans and samples."""
        n_steps = max(1, round(max(options.horizon for options in group.options) / float(model.step_time[0])))
        n_samples = max(options.samples for options in group.options)
        # All slots share the plans; the samples are scratch of each.
        nominal = np.zeros((len(model.present), len(group.members), n_steps, 2))
        group.tables = [
            (tables, Samples(nominal, np.zeros((n_samples, n_steps, 2)), np.zeros(n_samples)))
            for tables in LocalTables.reserve(group, model, n_slots)
        ]

    @staticmethod
    def begin(group: Group, shard: Shard) -> None:
        """Clear paths and plans."""
        tables, samples = group.tables[shard.slot]
        forget_ways(shard.worlds, tables.ways)
        forget_plans(shard.worlds, samples)

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' commands."""
        tables, samples = group.tables[shard.slot]
        find_paths(group, model, state, shard, tables)
        decide_mppi(shard.worlds, group.members, group.params, group.scan, model, state, tables, samples)
