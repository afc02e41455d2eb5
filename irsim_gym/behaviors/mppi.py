"""MPPI: model predictive path integral control (Williams et al. 2017) on the body's own scan."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from irsim_gym.behaviors import local_options, renewal
from irsim_gym.behaviors.local_paths import find_paths
from irsim_gym.behaviors.local_task import LocalTables
from irsim_gym.behaviors.local_way import forget_ways
from irsim_gym.behaviors.mppi_sampling import Samples, decide_mppi, forget_plans
from irsim_gym.scenario.options import kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


@kind
class Mppi:
    """Try random command sequences about the planned one, and plan their average, weighted by exp(-cost / temperature).

    The body sees what its first range sensor hits, and takes it to stand still. A sequence is driven by the limits of
    the drive; its cost is the integral over ``horizon`` [s] of
    ``goal_weight * g + path_weight * p + obstacle_weight * c``, with g, p and c as of ``dwa`` at each moment. Two
    sequences are no random ones: the planned one and a stop. What the average asks for first is the command; the rest
    is planned for the next decision. The noise comes from the world's random stream.
    """

    only_kernels: ClassVar[bool] = True
    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni", "acker")
    reads_neighbors: ClassVar[bool] = False
    reads_scan: ClassVar[bool] = True

    wander: bool = renewal.WANDER
    loop: bool = renewal.LOOP
    range_low: tuple[float, float, float] = renewal.LOW
    range_high: tuple[float, float, float] = renewal.HIGH
    wander_goals: renewal.WanderGoals = renewal.GOALS
    samples: int = option(
        200, ge=2, le=100_000, meaning="Number of sequences.", consequence="It is what a decision costs."
    )
    horizon: float = option(2.0, gt=0.0, le=60.0, unit="s", meaning="Duration of a sequence; in whole steps.")
    temperature: float = option(
        0.1, gt=0.0, unit="m s", meaning="Sequences that cost so much more than the best one count 1 / e as much."
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
    path_weight: float = option(0.5, ge=0.0, meaning="Weight of the distance from the path.")
    goal_weight: float = option(1.0, ge=0.0, meaning="Weight of what is left of the path.")
    path: local_options.Path = local_options.PATH
    path_clearance: float = local_options.PATH_CLEARANCE
    memory: float = local_options.MEMORY
    lookahead: float = local_options.LOOKAHEAD
    forward_point: float = local_options.FORWARD_POINT
    footprint_padding: float = local_options.PADDING
    obstacle_range: float = local_options.OBSTACLE_RANGE
    spacing: float = local_options.SPACING
    inflation_radius: float = local_options.INFLATION_RADIUS
    cost_scaling: float = local_options.COST_SCALING

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        yield from renewal.renewal_problems(self)

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> None:
        """Reserve memory for what the members see, follow, plan and try."""
        n_steps = max(1, round(max(options.horizon for options in group.options) / float(model.step_time[0])))
        n_samples = max(options.samples for options in group.options)
        nominal = np.zeros((len(model.present), len(group.members), n_steps, 2))
        group.tables = [
            (tables, Samples(nominal, np.zeros((n_samples, n_steps, 2)), np.zeros(n_samples)))
            for tables in LocalTables.reserve(group, model, n_slots)
        ]

    @staticmethod
    def begin(group: Group, shard: Shard) -> None:
        """Forget paths and plans."""
        tables, samples = group.tables[shard.slot]
        forget_ways(shard.worlds, tables.ways)
        forget_plans(shard.worlds, samples)

    @staticmethod
    def decide(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Write the members' commands."""
        tables, samples = group.tables[shard.slot]
        find_paths(group, model, state, shard, tables)
        decide_mppi(shard.worlds, group.members, group.params, group.scan, model, state, tables, samples)
