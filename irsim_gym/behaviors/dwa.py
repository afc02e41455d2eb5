"""DWA: the dynamic window approach (Fox, Burgard and Thrun 1997) on the body's own scan."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar, Literal

import numpy as np

from irsim_gym.behaviors.dwa_search import DwaTables, decide_dwa
from irsim_gym.behaviors.local_way import MOST_POINTS, LocalWays, find_ways, follows, forget_ways, note_scans
from irsim_gym.behaviors.rollouts import POSES
from irsim_gym.scenario.options import crossed_bounds, kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


@kind
class Dwa:
    """Take the command, of those that can be reached in a step, whose way ahead is free and costs least.

    The body sees what its first range sensor hits, and takes it to stand still. With a constant command it drives on a
    circle. A command is admissible if the body can stop before the way touches anything. The cost is
    ``obstacle_weight * c + path_weight * p + goal_weight * g``: c is 253 exp(-cost_scaling d) for the least distance d
    [m] of the padded footprint up to ``inflation_radius`` (as in ROS's cost maps), else 0, and 253 to 506 for a way
    that ends at something, the more the sooner; p is the distance of the way's end from the path [m], g that from the
    point ``lookahead`` ahead on the path [m].
    """

    only_kernels: ClassVar[bool] = True
    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni", "acker")
    reads_neighbors: ClassVar[bool] = False
    reads_scan: ClassVar[bool] = True

    wander: bool = option(False, meaning="Draw a new random goal after each arrival.")
    loop: bool = option(False, meaning="Begin again with the first goal after the last.")
    range_low: tuple[float, float, float] = option(
        (0.0, 0.0, -math.pi), unit="m, m, rad", meaning="Lower bounds of a wandering body's goals."
    )
    range_high: tuple[float, float, float] = option(
        (10.0, 10.0, math.pi), unit="m, m, rad", meaning="Upper bounds of a wandering body's goals."
    )
    samples: tuple[int, int] = option(
        (7, 21),
        meaning="Values of each of the command's two numbers: speed ahead and turn rate or steering angle, or the "
        "velocities along two axes.",
        consequence="Few: it swerves, or finds no way. Their product is what a decision costs.",
    )
    sim_time: float = option(2.0, gt=0.0, le=60.0, unit="s", meaning="How far ahead ways are looked at.")
    sim_granularity: float = option(
        0.1, gt=0.0, unit="s", meaning="Time between the poses at which a way is compared with the scan."
    )
    free_time: float | None = option(
        None,
        ge=0.0,
        unit="s",
        meaning="How long a way has to be free; default: a step, and what stopping takes by the limits of acceleration.",
    )
    min_speed: float = option(
        0.0,
        unit="m/s",
        meaning="Least speed ahead of diff and acker, beside turning on the spot; negative to drive backwards.",
    )
    escape_speed: float = option(
        0.0, le=0.0, unit="m/s", meaning="Speed, straight back, where no way ahead is admissible; 0: it stands."
    )
    min_turn_rate: float = option(0.1, ge=0.0, unit="rad/s", meaning="Least turn rate of diff on the spot.")
    oscillation_distance: float = option(
        0.25,
        ge=0.0,
        unit="m",
        meaning="Who has turned on the spot to both sides does so again only after moving so far.",
        consequence="0: it may turn to and fro for ever.",
    )
    obstacle_weight: float = option(0.02, ge=0.0, unit="m", meaning="Weight of the nearness of obstacles.")
    path_weight: float = option(0.5, ge=0.0, meaning="Weight of the distance from the path.")
    goal_weight: float = option(1.0, ge=0.0, meaning="Weight of the distance from the point ahead on the path.")
    path: Literal["straight", "map", "seen"] = option(
        "straight",
        meaning="The path to follow: straight to the goal; the shortest around all that never moves and the map; or a "
        "short one around what its own scans have shown.",
    )
    memory: float = option(60.0, gt=0.0, unit="s", meaning="How long path seen remembers what a scan has shown.")
    path_clearance: float = option(
        0.1, ge=0.0, unit="m", meaning="How far a path over the map keeps from obstacles, or half of it, or as it can."
    )
    spacing: float = option(
        0.02, ge=0.0, unit="m", meaning="A hit that is nearer than this to the one of the beam before it is passed over."
    )
    lookahead: float = option(2.0, gt=0.0, unit="m", meaning="How far ahead on the path that point is.")
    forward_point: float = option(
        0.3,
        ge=0.0,
        unit="m",
        meaning="The end of a way of diff and acker is measured so far ahead of the body, or less near the goal.",
    )
    footprint_padding: float = option(
        0.05, ge=0.0, unit="m", meaning="Added to the footprint; who is nearer already may go where it is no nearer."
    )
    obstacle_range: float = option(2.5, gt=0.0, unit="m", meaning="Hits farther from the sensor are not seen.")
    inflation_radius: float = option(
        0.5, ge=0.0, unit="m", meaning="Obstacles farther than this from the padded footprint cost nothing."
    )
    cost_scaling: float = option(5.0, ge=0.0, unit="1/m", meaning="How fast their cost falls with the distance.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        yield from crossed_bounds(self.range_low, self.range_high)
        if min(self.samples) < 1 or max(self.samples) > MOST_SAMPLES:
            yield "samples", f"must be two numbers from 1 to {MOST_SAMPLES}, got {list(self.samples)}"
        if self.sim_granularity > self.sim_time:
            yield "sim_granularity", f"must not exceed sim_time = {self.sim_time:g}, got {self.sim_granularity:g}"

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> None:
        """Reserve scratch memory, and note who is commanded by turn rates."""
        assert group.scan is not None and group.context is not None
        by_rate = np.zeros(len(model.role), np.bool_)
        for b in group.members:
            by_rate[b] = getattr(group.context.bodies[b].kinematics, "mode", "") == "angular"
        n_beams = group.scan.ranges.shape[2]
        shape = len(model.present), len(group.members)
        origin, turned = np.full((*shape, 2), np.nan), np.zeros(shape, np.int64)
        group.tables = [
            DwaTables(
                by_rate, np.zeros((2, n_beams)), np.zeros(1, POSES), np.zeros((2, MOST_POINTS + 1)), ways, origin, turned
            )
            for ways in LocalWays.reserve(group, model, n_slots)
        ]

    @staticmethod
    def begin(group: Group, shard: Shard) -> None:
        """Forget the paths, and where the members have turned."""
        tables = group.tables[shard.slot]
        forget_ways(shard.worlds, tables.ways)
        tables.origin[shard.worlds] = np.nan

    @staticmethod
    def decide(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Write the members' commands."""
        tables = group.tables[shard.slot]
        if follows(group, "seen"):
            scan, hits = group.scan, tables.hits
            note_scans(shard.worlds, group.members, group.params, scan, model, state, hits, tables.ways)
        if follows(group, "map"):
            find_ways(shard.worlds, group.members, group.params, model, model.cells, state, tables.ways)
        decide_dwa(shard.worlds, group.members, group.params, group.scan, model, state, tables)


MOST_SAMPLES = 1000
