"""Hybrid A*: a path over poses for the body's own outline, planned once and followed forwards and backwards."""

from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.bodies.behaviors.hybrid_astar.drive import drive_poses
from irsim_gym.bodies.behaviors.hybrid_astar.tables import PoseTables, forget_poses
from irsim_gym.bodies.behaviors.pursuit.drive import is_under_way, mark_moving
from irsim_gym.bodies.behaviors.shared.steering import clear_command
from irsim_gym.scenario.specs.wander_goals import RenewsGoals
from irsim_gym.simulator.paths.clearance import Obstacles, mark_standing
from irsim_gym.simulator.world.names import Cells, Flags, Group, Ints, Model, Shard, State, kernel, kind, option


@kind
class HybridAstar(RenewsGoals):
    """Plan a path over poses to the goal around all standing obstacles, and follow it forwards and backwards.

    The path consists of arcs within the turning limits of the body, and of turns on the spot for ``diff``, along which
    the body's own outline touches nothing. It leads to a position, or with ``arrive_mode: state`` to a position and a
    heading, and takes little time, including changes of direction. Moving bodies are not part of the plan: the body
    waits for those close ahead, and does not drive around them.
    """

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "acker")
    reads_neighbors: ClassVar[bool] = False

    target_roles: Literal["all", "robot", "obstacle"] = option("all", meaning="Which moving bodies it stops for.")
    clearance: float = option(0.1, gt=0.0, unit="m", meaning="Closer to obstacles, time costs up to three times more.")
    cell: float | None = option(
        None,
        gt=0.0,
        unit="m",
        meaning="Cell size of the search; default: 0.75 times the radius of the largest disc about the origin in the "
        "body.",
        consequence="Large: narrow ways are missed. Small: the search takes longer, and gives up sooner.",
    )

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Allocate memory for the paths."""
        group.tables = PoseTables.reserve(group, model, n_slots)

    @staticmethod
    def begin(group: Group, shard: Shard) -> None:
        """Clear the paths of worlds that begin."""
        forget_poses(shard.worlds, group.tables)

    @staticmethod
    def wayless(group: Group) -> Flags:
        """Return which members looked for a way to their goal and found none, shape ``(n_worlds, n_members)``."""
        return np.asarray((group.tables.count == 0) & ~np.isnan(group.tables.goal[:, :, 0]))

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' commands; all members of a group have one drive."""
        drive_all_poses(shard.worlds, shard.slot, group.members, group.params, group.tables, model, model.cells, state)


@kernel
def drive_all_poses(
    worlds: Ints, slot: int, members: Ints, params: Any, tables: PoseTables, model: Model, cells: Cells, state: State
) -> None:
    """Write the commands of the members.

    Reads: tables (by_rate, cell, count, discs, everything, goal, grid, memory, moves, piece, pieces, retry, segments,
        share, standing), model (has_goal, heedless, movable, present, role, seen_row, stands, unobstructed, watchers),
        state (arrived, goal, stopped).
    Writes: tables (count, everything, goal, piece, pieces, retry, share, standing), state (command).
    """
    standing, everything = tables.standing[slot], tables.everything[slot]
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            clear_command(state, w, b)
            if not is_under_way(model, state, w, b):
                continue
            # The plan avoids what stands; whether the body may go on is tested against what moves as well.
            mark_standing(model, w, b, standing)
            mark_moving(model, w, b, params[k].target_roles, standing, everything)
            fixed = Obstacles(model, state, w, standing, cells, None)
            drive_poses(fixed, Obstacles(model, state, w, everything, cells, None), params[k], tables, slot, b)
