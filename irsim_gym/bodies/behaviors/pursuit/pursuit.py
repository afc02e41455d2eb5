"""Pursuit: the shortest path on the map, followed by regulated pure pursuit."""

from collections.abc import Iterator
from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.bodies.behaviors.pursuit.drive import is_under_way, mark_moving, pursue
from irsim_gym.bodies.behaviors.pursuit.seen import pursue_seen
from irsim_gym.bodies.behaviors.pursuit.tables import PursuitTables, forget_ways
from irsim_gym.bodies.behaviors.shared.steering import clear_command
from irsim_gym.scenario.specs.wander_goals import RenewsGoals
from irsim_gym.simulator.paths.clearance import Obstacles, mark_standing
from irsim_gym.simulator.world.names import Cells, Flags, Group, Ints, Model, Shard, State, kernel, kind, option


@kind
class Pursuit(RenewsGoals):
    """Plan the shortest path to the goal around all standing obstacles, and follow it by regulated pure pursuit.

    A body counts as the disc about its origin that encloses it. Moving bodies are not part of the plan: the body waits
    for those close ahead, and does not drive around them. With ``known: seen``, it knows only what its scans have hit,
    including bodies that have moved since, and plans again if a new obstacle blocks its path; without a path, it
    forgets all but its latest scan.
    """

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni", "omni_angular", "acker")
    reads_neighbors: ClassVar[bool] = False

    target_roles: Literal["all", "robot", "obstacle"] = option(
        "all", meaning="Which other bodies that move it stops for; all that stand are on the map."
    )
    known: Literal["all", "seen"] = option(
        "all", meaning="What it knows: all that stands, or what its scans have shown, the rest taken as free."
    )
    clearance: float = option(0.1, ge=0.0, unit="m", meaning="Distance of ways from obstacles; less where none has it.")
    cell: float | None = option(None, gt=0.0, unit="m", meaning="Cell size; default: half the radius.")
    speed: float | None = option(None, gt=0.0, unit="m/s", meaning="Maximum speed; by default the drive's.")
    lookahead_time: float = option(0.6, ge=0.0, unit="s", meaning="It aims at a point this much driving ahead.")
    lookahead_min: float = option(0.3, gt=0.0, unit="m", meaning="Minimum distance of that point.")
    lookahead_max: float | None = option(None, gt=0.0, unit="m", meaning="Maximum distance of that point.")
    min_radius: float = option(0.5, ge=0.0, unit="m", meaning="Curves below this radius are driven slower.")
    proximity: float = option(0.1, ge=0.0, unit="m", meaning="Nearer to an obstacle it is slower, in proportion.")
    proximity_gain: float = option(1.0, gt=0.0, le=1.0, meaning="Factor of that: the lower the slower.")
    min_speed: float = option(0.25, ge=0.0, unit="m/s", meaning="Curves and obstacles never slow it below this.")
    approach: float = option(0.6, ge=0.0, unit="m", meaning="Nearer to the goal it is slower, in proportion.")
    approach_speed: float = option(0.05, ge=0.0, unit="m/s", meaning="Minimum speed at the goal.")
    turn_angle: float = option(0.785, gt=0.0, unit="rad", meaning="Beyond this angle a diff turns on the spot.")

    def further_problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        if self.lookahead_max is not None and self.lookahead_max < self.lookahead_min:
            yield "lookahead_max", f"must be >= lookahead_min, {self.lookahead_min:g}, got {self.lookahead_max:g}"

    @property
    def reads_scan(self) -> bool:
        """Whether the body needs a range sensor."""
        return self.known == "seen"

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Allocate memory for the paths, and fill in default options."""
        speed = group.params["speed"]
        # NaN stands for None in tables of options; infinity is no limit in every minimum.
        group.params["speed"] = np.where(np.isnan(speed), np.inf, speed)
        group.tables = PursuitTables.reserve(group, model, n_slots)

    @staticmethod
    def begin(group: Group, shard: Shard) -> None:
        """Clear the paths of worlds that begin."""
        forget_ways(shard.worlds, group.tables)

    @staticmethod
    def wayless(group: Group) -> Flags:
        """Return which members looked for a way to their goal and found none, shape ``(n_worlds, n_members)``."""
        return np.asarray((group.tables.count == 0) & ~np.isnan(group.tables.goal[:, :, 0]))

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' commands; all members of a group have one drive."""
        worlds, slot, members, params, tables = shard.worlds, shard.slot, group.members, group.params, group.tables
        if group.scan is None:
            pursue_known(worlds, slot, members, params, tables, model, model.cells, state)
        else:
            pursue_seen(worlds, slot, members, params, tables, group.scan, model, state)


@kernel
def pursue_known(
    worlds: Ints, slot: int, members: Ints, params: Any, tables: PursuitTables, model: Model, cells: Cells, state: State
) -> None:
    """Write the commands of bodies that know all that stands.

    Reads: tables (back, by_rate, coarse, count, everything, fine, goal, margin, points, retry, side, standing, whole),
        model (has_goal, heedless, movable, present, role, seen_row, stands, unobstructed, watchers), state (arrived,
        goal, stopped).
    Writes: tables (back, coarse, count, everything, fine, goal, margin, points, retry, side, standing, whole), state
        (command).
    """
    standing, everything = tables.standing[slot], tables.everything[slot]
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            clear_command(state, w, b)
            if not is_under_way(model, state, w, b):
                continue
            mark_standing(model, w, b, standing)
            mark_moving(model, w, b, params[k].target_roles, standing, everything)
            fixed = Obstacles(model, state, w, standing, cells, None)
            pursue(fixed, Obstacles(model, state, w, everything, cells, None), params[k], tables, slot, b)
