"""The paths over poses of the members of a group, and the tables for planning them."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats, Ints, Records
from irsim_gym.bodies.behaviors.hybrid_astar.costs import (
    COARSE,
    FARTHEST,
    LEAST_HALF,
    N_TURNS,
    TURNS_AWAY,
    Aim,
    lay_costs,
)
from irsim_gym.bodies.behaviors.hybrid_astar.moves import MOST_MOVES, MOVE, lay_moves
from irsim_gym.bodies.behaviors.hybrid_astar.queue import PoseNodes
from irsim_gym.bodies.behaviors.pursuit.motion import Moving
from irsim_gym.bodies.behaviors.pursuit.tables import WayGrid
from irsim_gym.bodies.behaviors.shared.steering import commanded_by_rate
from irsim_gym.simulator.cell_paths.outline_room import largest_disc
from irsim_gym.simulator.world.model import STATE, Model
from irsim_gym.simulator.world.names import Group, Struct, kernel, row_of

MOST_PIECES = 256
"""Maximum number of stored moves of a path; a longer path is planned again at their end."""
X, Y, HEADING, AHEAD, LEFT, TURN, GEAR = 0, 1, 2, 3, 4, 5, 6
"""Columns of ``PoseWay.pieces``."""
CELL = 0.75
"""Side of the cells of the search, as a share of the radius of the largest disc about the origin within the body."""
THIN = 0.25
"""Share of its reach that stands for that radius where it is less."""
FIELD_CELL = 0.3
"""Side of the cells over which a disc within the body is led, as a share of that radius: none of the gaps through which
the body fits is missed, see ``simulator.paths.reachability``."""
NEARER = 0.6
"""Share of the arrival threshold within which paths end."""


class PoseWay(NamedTuple):
    """A path over poses.

    Attributes:
        pieces: Its moves: where each begins, x, y, heading [m, m, rad], how far it leads ahead and to the left [m], how
            far it turns [rad], its gear; shape ``(n_pieces, 7)``.
        n_pieces: Number of moves.
    """

    pieces: Floats
    n_pieces: int


@dataclass(repr=False)
class PoseTables(Struct):
    """The paths of the members over poses, and the tables for planning them.

    Attributes:
        cell: Side of a member's cells [m], shape ``(n_members,)``.
        by_rate: Members whose second number of a command is a turn rate of a car, as ``cell``.
        table: Number of the table of each member, as ``cell``.
        costs: Costs of ways where nothing is in the way, of those who move alike [s], shape ``(n_tables, columns, rows,
            N_TURNS)``.
        goal: Where each way leads [m, m, rad], NaN in x without one, shape ``(n_worlds, n_members, 3)``; the first two
            axes are the same in all that follow.
        pieces: See ``PoseWay``, shape ``(n_worlds, n_members, MOST_PIECES, 7)``.
        count: Number of moves of the way; 0 without one.
        piece: The move at which the body is.
        share: How much of it lies behind.
        retry: The step from which on a way may be looked for again.
        grid: The grid on which a disc within the body is led.
        nodes: Scratch: the poses of a search.
        moves: Scratch: the moves of a body, shape ``(n_slots, MOST_MOVES)``.
        segments: Scratch: an outline at a pose, shape ``(n_slots, n_segments, 4)``.
        discs: Scratch, shape ``(n_slots, n_discs, 3)``.
        standing: Scratch: what stands in the way, shape ``(n_slots, n_bodies)``.
        everything: Scratch: that, and what moves, shape ``(n_slots, n_bodies)``.
    """

    cell: Floats
    by_rate: Flags
    table: Ints
    costs: Floats
    goal: Floats
    pieces: Floats
    count: Ints
    piece: Ints
    share: Floats
    retry: Ints
    grid: WayGrid
    nodes: PoseNodes
    moves: Records
    segments: Floats
    discs: Floats
    standing: Flags
    everything: Flags

    @classmethod
    def reserve(cls, group: Group, model: Model, n_slots: int) -> Self:
        """Return memory for the members of a group; nobody has a way yet."""
        shape, n_bodies = (len(model.present), len(group.members)), len(model.role)
        inner = np.array([inner_radius_of(model, 0, b) for b in group.members.tolist()])
        given = group.params["cell"]
        cell, by_rate = np.where(np.isnan(given), CELL * inner, given), commanded_by_rate(group)
        field_cell = float(np.min(np.where(np.isnan(given), FIELD_CELL * inner, given)))
        # The memory of searches also serves for laying the tables of costs.
        nodes = PoseNodes.reserve(n_slots)
        table, costs = _costs(group, model, cell, by_rate, nodes)
        return cls(
            cell=cell,
            by_rate=by_rate,
            table=table,
            costs=costs,
            goal=np.full((*shape, 3), np.nan),
            pieces=np.zeros((*shape, MOST_PIECES, 7)),
            count=np.zeros(shape, np.int64),
            piece=np.zeros(shape, np.int64),
            share=np.zeros(shape),
            retry=np.zeros(shape, np.int64),
            grid=WayGrid.over(model.bounds, field_cell, n_slots),
            nodes=nodes,
            moves=np.zeros((n_slots, MOST_MOVES), MOVE),
            segments=np.zeros((n_slots, model.local_segments.shape[1], 4)),
            discs=np.zeros((n_slots, model.local_discs.shape[1], 3)),
            standing=np.zeros((n_slots, n_bodies), np.bool_),
            everything=np.zeros((n_slots, n_bodies), np.bool_),
        )


@kernel
def inner_radius_of(model: Model, w: int, b: int) -> float:
    """Return the radius of the largest disc about the origin of body b of world w within it [m], at least some.

    Reads: model (disc_count, disc_start, local_discs, local_segments, reach, segment_count, segment_start, solid).
    """
    return float(max(largest_disc(model, w, b), THIN * model.reach[row_of(model.reach, w), b]))


@kernel
def forget_poses(worlds: Ints, tables: PoseTables) -> None:
    """Forget all ways of some worlds.

    Writes: tables (count, goal, retry).
    """
    for w in worlds:
        for m in range(tables.retry.shape[1]):
            tables.goal[w, m, 0], tables.retry[w, m], tables.count[w, m] = np.nan, 0, 0


def _costs(group: Group, model: Model, cell: Floats, by_rate: Flags, nodes: PoseNodes) -> tuple[Ints, Floats]:
    """Return the number of each member's table of costs without obstacles, and the tables.

    Those who move alike share one; the first one is of zeros, for those who do not turn. Where levels draw speeds, the
    tables are those of the first level.
    """
    asked = [_asked(group, model, k, float(cell[k]), bool(by_rate[k])) for k in range(len(group.members))]
    half = max([LEAST_HALF, *(_half(model, moves, float(side)) for (moves, _), side in zip(asked, cell, strict=True))])
    # All tables have the size of the largest, so that they stack.
    tables, found = [np.zeros((2 * half + 1, 2 * half + 1, N_TURNS))], {b"": 0}
    numbers = np.zeros(len(asked), np.int64)
    for k, (moves, aim) in enumerate(asked):
        change = group.options[k].change_cost
        # Equal moves, goals and costs give equal tables.
        alike = moves.tobytes() + repr((aim, change, cell[k])).encode() if moves["turn"].any() else b""
        if alike not in found:
            found[alike] = len(tables)
            tables.append(np.zeros((2 * half + 1, 2 * half + 1, N_TURNS)))
            # Slot 0's memory; no search has begun yet.
            scratch = PoseNodes(*(part[0] for part in nodes))
            lay_costs(group.params[k], aim, COARSE * float(cell[k]), moves, scratch, tables[-1])
        numbers[k] = found[alike]
    return numbers, np.stack(tables)


def _asked(group: Group, model: Model, k: int, cell: float, by_rate: bool) -> tuple[Records, Aim]:
    """Return the moves of a member, and its goal as if that were the origin."""
    b, still, moves = int(group.members[k]), np.zeros(3), np.zeros(MOST_MOVES, MOVE)
    moving = Moving(
        int(model.drive[b]), by_rate, float(model.wheelbase[b]), float(model.step_time[0]), still, 0.0, still,
        model.velocity_min[0, b], model.velocity_max[0, b], model.acceleration_limit[0, b],
    )  # fmt: skip
    count = lay_moves(moving, cell, moves)
    heading = 0.0 if model.arrive_mode[b] == STATE else np.nan
    return moves[:count], Aim(0.0, 0.0, heading, NEARER * float(model.goal_threshold[0, b]))


def _half(model: Model, moves: Records, cell: float) -> int:
    """Return how many cells the table of costs of a body with these moves reaches from the goal, within the world."""
    arcs = moves[(moves["turn"] != 0.0) & (moves["ahead"] != 0.0)]
    # Of the sharpest arc: the radius is its length divided by its turn.
    radius = float(np.min(np.abs(arcs["ahead"] / arcs["turn"]), initial=np.inf)) if len(arcs) else 0.0
    x_min, y_min, x_max, y_max = model.bounds
    reach = min(TURNS_AWAY * radius, max(x_max - x_min, y_max - y_min))
    return int(np.clip(np.ceil(reach / (COARSE * cell)), LEAST_HALF, FARTHEST))
