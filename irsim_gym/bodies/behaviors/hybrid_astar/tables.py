"""The paths over poses of the members of a group, and the tables for planning them."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from irsim_gym.bodies.behaviors.hybrid_astar.moves import MOST_MOVES, MOVE
from irsim_gym.bodies.behaviors.hybrid_astar.queue import PoseMemory
from irsim_gym.bodies.behaviors.pursuit.tables import WayGrid
from irsim_gym.bodies.behaviors.shared.steering import commanded_by_rate
from irsim_gym.simulator.cell_paths.outline_room import largest_disc
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.names import Flags, Floats, Group, Ints, Records, Struct, kernel, record_type, row_of

MOST_PIECES = 256
"""Maximum number of stored moves of a path; a longer path is planned again at their end."""
PIECE = record_type("x y heading ahead turn", gear=np.int64)
"""A move of a path: where it begins [m, m, rad], how far it leads ahead [m] and turns [rad], and its gear."""
CELL = 0.75
"""Side of the cells of the search, as a share of the radius of the largest disc about the origin within the body."""
THIN = 0.25
"""Share of its reach that stands for that radius where it is less."""
FIELD_CELL = 0.3
"""Side of the cells over which a disc within the body is led, as a share of that radius: none of the gaps through which
the body fits is missed, see ``simulator.paths.reachability``."""


class PoseWay(NamedTuple):
    """A path over poses.

    Attributes:
        pieces: Its moves: records of type ``PIECE``, shape ``(n_pieces,)``.
        n_pieces: Number of moves.
    """

    pieces: Records
    n_pieces: int


@dataclass(repr=False)
class PoseTables(Struct):
    """The paths of the members over poses, and the tables for planning them.

    Attributes:
        cell: Side of a member's cells [m], shape ``(n_members,)``.
        by_rate: Members whose second number of a command is a turn rate of a car, as ``cell``.
        goal: Where each way leads [m, m, rad], NaN in x without one, shape ``(n_worlds, n_members, 3)``; the first two
            axes are the same in all that follow.
        pieces: See ``PoseWay``, shape ``(n_worlds, n_members, MOST_PIECES)``.
        count: Number of moves of the way; 0 without one.
        piece: The move at which the body is.
        share: How much of it lies behind.
        retry: The step from which on a way may be looked for again.
        grid: The grid on which a disc within the body is led.
        memory: Scratch: the poses of a search.
        moves: Scratch: the moves of a body, shape ``(n_slots, MOST_MOVES)``.
        segments: Scratch: an outline at a pose, shape ``(n_slots, n_segments, 4)``.
        discs: Scratch, shape ``(n_slots, n_discs, 3)``.
        standing: Scratch: what stands in the way, shape ``(n_slots, n_bodies)``.
        everything: Scratch: that, and what moves, shape ``(n_slots, n_bodies)``.
    """

    cell: Floats
    by_rate: Flags
    goal: Floats
    pieces: Records
    count: Ints
    piece: Ints
    share: Floats
    retry: Ints
    grid: WayGrid
    memory: PoseMemory
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
        asked = group.params["cell"]
        field_cell = float(np.min(np.where(np.isnan(asked), FIELD_CELL * inner, asked)))
        return cls(
            cell=np.where(np.isnan(asked), CELL * inner, asked),
            by_rate=commanded_by_rate(group),
            goal=np.full((*shape, 3), np.nan),
            pieces=np.zeros((*shape, MOST_PIECES), PIECE),
            count=np.zeros(shape, np.int64),
            piece=np.zeros(shape, np.int64),
            share=np.zeros(shape),
            retry=np.zeros(shape, np.int64),
            grid=WayGrid.over(model.bounds, field_cell, n_slots),
            memory=PoseMemory.reserve(n_slots),
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
