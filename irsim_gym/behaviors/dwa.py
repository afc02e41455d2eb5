"""DWA: the dynamic window approach (Fox, Burgard and Thrun 1997) on the body's own scan."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from irsim_gym.behaviors import local_options, renewal
from irsim_gym.behaviors.dwa_search import Turns, decide_dwa, forget_turns
from irsim_gym.behaviors.local_paths import find_paths
from irsim_gym.behaviors.local_task import LocalTables
from irsim_gym.behaviors.local_way import forget_ways
from irsim_gym.scenario.options import kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState

MOST_SAMPLES = 1000
"""Most values along an axis."""


@kind
class Dwa:
    """Take the command, of those that can be reached in a step, whose way ahead is free and costs least.

    The body sees what its first range sensor hits, and takes it to stand still. With a constant command it drives on a
    circle. A command is admissible if the body can stop before the way touches anything. The cost is
    ``obstacle_weight * c + path_weight * p + goal_weight * g``: c is 253 exp(-cost_scaling d) for the least distance d
    [m] of the padded footprint up to ``inflation_radius`` (as in ROS's cost maps), else 0, and 253 to 506 for a way
    that ends at something, the more the sooner; p is the distance of the way's end from the path [m], and g what is
    left of the path from there on [m]; a way that arrives has driven on for the time that it saves.
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
    samples: tuple[int, int] = option(
        (7, 21),
        meaning="Values of each of the command's two numbers: speed ahead and turn rate or steering angle, or the "
        "velocities along two axes.",
        consequence="Few: it swerves, or finds no way. Their product is what a decision costs.",
    )
    sim_time: float = option(1.5, gt=0.0, le=60.0, unit="s", meaning="How far ahead ways are looked at.")
    sim_granularity: float = option(
        0.1, gt=0.0, unit="s", meaning="Time between the poses at which a way is compared with the scan."
    )
    free_time: float | None = option(
        None,
        ge=0.0,
        unit="s",
        meaning="How long a way has to be free; default: a step, and half of what stopping takes.",
    )
    min_speed: float = option(
        0.0,
        unit="m/s",
        meaning="Least speed ahead of diff and acker, beside turning on the spot; negative to drive backwards.",
    )
    escape_speed: float = option(
        0.0, le=0.0, unit="m/s", meaning="Speed, straight back, where no way ahead is admissible; 0: it stands."
    )
    min_turn_rate: float = option(
        0.5, ge=0.0, unit="rad/s", meaning="Least turn rate of diff on the spot, or the fastest that a step reaches."
    )
    oscillation_distance: float = option(
        0.25,
        ge=0.0,
        unit="m",
        meaning="Who has turned on the spot to both sides does so again only after moving so far.",
        consequence="0: it may turn to and fro for ever.",
    )
    obstacle_weight: float = option(0.002, ge=0.0, unit="m", meaning="Weight of the nearness of obstacles.")
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
        if min(self.samples) < 1 or max(self.samples) > MOST_SAMPLES:
            yield "samples", f"must be two numbers from 1 to {MOST_SAMPLES}, got {list(self.samples)}"
        if self.sim_granularity > self.sim_time:
            yield "sim_granularity", f"must not exceed sim_time = {self.sim_time:g}, got {self.sim_granularity:g}"

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> None:
        """Reserve memory for what the members see and follow, and for how they have turned."""
        shape = len(model.present), len(group.members)
        turns = Turns(np.full((*shape, 2), np.nan), np.zeros(shape, np.int64))
        group.tables = [(tables, turns) for tables in LocalTables.reserve(group, model, n_slots)]

    @staticmethod
    def begin(group: Group, shard: Shard) -> None:
        """Forget the paths, and how the members have turned."""
        tables, turns = group.tables[shard.slot]
        forget_ways(shard.worlds, tables.ways)
        forget_turns(shard.worlds, turns)

    @staticmethod
    def decide(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Write the members' commands."""
        tables, turns = group.tables[shard.slot]
        find_paths(group, model, state, shard, tables)
        decide_dwa(shard.worlds, group.members, group.params, group.scan, model, state, tables, turns)
