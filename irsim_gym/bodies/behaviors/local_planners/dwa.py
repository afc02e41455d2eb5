"""DWA: the dynamic window approach (Fox, Burgard and Thrun 1997) on the body's own scan."""

from collections.abc import Iterator
from typing import ClassVar, Literal

import numpy as np

from irsim_gym.bodies.behaviors.local_planners.dwa_search import Turns, decide_dwa, forget_turns
from irsim_gym.bodies.behaviors.local_planners.paths import find_paths
from irsim_gym.bodies.behaviors.local_planners.task import LocalTables
from irsim_gym.bodies.behaviors.local_planners.way import forget_ways
from irsim_gym.scenario.specs.wander_goals import RenewsGoals
from irsim_gym.simulator.world.names import Group, Model, Shard, State, kind, option

MOST_SAMPLES = 1000
"""Maximum number of values along an axis."""


@kind
class Dwa(RenewsGoals):
    """Choose the command with the lowest cost among admissible commands that can be reached within a step.

    The body sees what its first range sensor hits, and assumes that it stands still. A constant command moves the body
    along a circular arc. A command is admissible if the body can stop before the arc touches anything. The cost is
    ``obstacle_weight * c + path_weight * p + goal_weight * g``. c is 253 exp(-cost_scaling d) for the smallest distance
    d [m] of the padded footprint up to ``inflation_radius`` (as in ROS's cost maps), and 0 beyond; for an arc that ends
    at an obstacle, it is 253 to 506, higher for earlier ends. p is the distance of the arc's end from the path [m], and
    g is the rest of the path from there [m]. An arc that arrives early counts as if it continued for the time saved.
    """

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni", "acker")
    reads_neighbors: ClassVar[bool] = False
    reads_scan: ClassVar[bool] = True

    path: Literal["straight", "map", "seen"] = option(
        "seen",
        meaning="The path to follow: straight (to the goal), map (the shortest one around the map and all that never "
        "moves), or seen (a short one around what its own scans have shown).",
    )
    path_clearance: float = option(0.1, ge=0.0, unit="m", meaning="Distance of a path from obstacles, where possible.")
    memory: float = option(60.0, gt=0.0, unit="s", meaning="How long path seen remembers what a scan has shown.")
    lookahead: float = option(
        4.0,
        gt=0.0,
        unit="m",
        meaning="Length of the part of the path that counts.",
        consequence="Shorter than what it can drive in the time that it looks ahead: it drives slower.",
    )
    forward_point: float = option(
        0.3, ge=0.0, unit="m", meaning="For diff and acker, ways count at a point this far ahead, so that turns matter."
    )
    footprint_padding: float = option(
        0.02, ge=0.0, unit="m", meaning="Added to the footprint. A body nearer already may move if it gets no nearer."
    )
    obstacle_range: float = option(2.5, gt=0.0, unit="m", meaning="Hits farther from the sensor are ignored.")
    spacing: float = option(0.02, ge=0.0, unit="m", meaning="A hit closer than this to the one before is ignored.")
    inflation_radius: float = option(0.5, ge=0.0, unit="m", meaning="Obstacles farther away cost nothing.")
    cost_scaling: float = option(5.0, ge=0.0, unit="1/m", meaning="How fast the cost of obstacles falls with distance.")
    path_weight: float = option(0.5, ge=0.0, meaning="Weight of the distance from the path.")
    goal_weight: float = option(1.0, ge=0.0, meaning="Weight of the rest of the path.")
    samples: tuple[int, int] = option(
        (7, 21),
        meaning="Number of values of each of the command's two numbers: speed and turn rate or steering angle, or the "
        "velocities along two axes.",
        consequence="Few: it swerves, or finds no way. Computing time grows with the product.",
    )
    sim_time: float = option(1.5, gt=0.0, le=60.0, unit="s", meaning="Duration of the ways that are compared.")
    sim_granularity: float = option(0.1, gt=0.0, unit="s", meaning="Time between poses compared with the scan.")
    free_time: float | None = option(None, ge=0.0, unit="s", meaning="How long a way must be free; default: by speed.")
    min_speed: float = option(0.0, unit="m/s", meaning="Least speed of diff and acker ahead; below 0: backwards.")
    escape_speed: float = option(0.0, le=0.0, unit="m/s", meaning="Speed back when no way is admissible; 0: none.")
    min_turn_rate: float = option(0.5, ge=0.0, unit="rad/s", meaning="Least turn rate of diff on the spot.")
    oscillation_distance: float = option(
        0.25,
        ge=0.0,
        unit="m",
        meaning="After turns on the spot to both sides, it makes no further one before it has moved this far.",
        consequence="0: it may turn to and fro for ever.",
    )
    obstacle_weight: float = option(0.002, ge=0.0, unit="m", meaning="Weight of the nearness of obstacles.")

    def further_problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        if min(self.samples) < 1 or max(self.samples) > MOST_SAMPLES:
            yield "samples", f"must be two numbers from 1 to {MOST_SAMPLES}, got {list(self.samples)}"
        if self.sim_granularity > self.sim_time:
            yield "sim_granularity", f"must not exceed sim_time = {self.sim_time:g}, got {self.sim_granularity:g}"

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Allocate memory for the members' scans, paths and turns."""
        shape = len(model.present), len(group.members)
        # All slots share these rows: a shard touches those of its own worlds only.
        turns = Turns(np.full((*shape, 2), np.nan), np.zeros(shape, np.int64))
        group.tables = [(tables, turns) for tables in LocalTables.reserve(group, model, n_slots)]

    @staticmethod
    def begin(group: Group, shard: Shard) -> None:
        """Clear the paths and turns."""
        tables, turns = group.tables[shard.slot]
        forget_ways(shard.worlds, tables.ways)
        forget_turns(shard.worlds, turns)

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' commands."""
        tables, turns = group.tables[shard.slot]
        worlds, members, params, scan = shard.worlds, group.members, group.params, group.scan
        find_paths(worlds, members, params, scan, model, model.cells, state, tables)
        decide_dwa(worlds, members, params, scan, model, state, tables, turns)
