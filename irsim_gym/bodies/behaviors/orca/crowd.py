"""The members of an ORCA group sorted by the squares of a grid, and the search for the nearest ones.

A square grid covers the world. Members outside of it are put into the nearest square at its border, so none is missed.
A search looks at a ring of squares about its own, and at wider ones until it has found enough members.
"""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from irsim_gym.base.kernels.structs import Struct, record_type
from irsim_gym.bodies.behaviors.orca.lines import DISC_LANES
from irsim_gym.bodies.behaviors.shared.surroundings import Ego
from irsim_gym.simulator.geometry.buckets import square_of
from irsim_gym.simulator.world.names import Flags, Floats, Ints, Model, Records, State, kernel, row_of

FEW = 32
"""Number of members up to which they are searched one by one."""

ROUNDING = 1.0 + 1e-9
"""Factor by which a square is wider than the range that a ring of squares must cover."""


MOVE = record_type("vx vy radius")
"""Velocity [m/s] and radius [m] of a member."""


class Squares(NamedTuple):
    """The squares into which members are sorted.

    Attributes:
        x: Lower left corner [m].
        y: Lower left corner [m].
        side: Side of a square [m].
        columns: Number of squares along x.
        rows: Number of squares along y.
        first_ring: Distance up to which the first ring of squares about a member's holds all others [m].
    """

    x: float
    y: float
    side: float
    columns: int
    rows: int
    first_ring: float


@dataclass
class Crowd(Struct):
    """The members of a group, and scratch memory of one shard for those of one world.

    Attributes:
        members: Bodies that see or are seen, shape ``(n_members,)``.
        squares: The squares into which they are sorted.
        seen: Flags of bodies that can be seen, shape ``(body,)``.
        plans: Flags of bodies that plan, shape ``(body,)``.
        x: x of each present member, square by square; infinite for members that no body sees [m].
        y: y of each present member, likewise [m].
        moves: Motion of each present member, records of type ``MOVE``.
        body: Body of each present member.
        square: Square of each member of the group, -1 for absent members.
        starts: First member in each square.
        found: Members found by a search.
        gap2: Their squared distances [m2].
        nearest: The nearest of them, nearest first.
        nearest_gap: Squared distances of the nearest ones [m2].
        lanes: Input and output of ``disc_planes``, shape ``(1,)``.
    """

    members: Ints
    squares: Squares
    seen: Flags
    plans: Flags
    x: Floats
    y: Floats
    moves: Records
    body: Ints
    square: Ints
    starts: Ints
    found: Ints
    gap2: Floats
    nearest: Ints
    nearest_gap: Floats
    lanes: Records

    @classmethod
    def reserve(cls, members: Ints, squares: Squares, seen: Flags, plans: Flags, most: int) -> Self:
        """Return memory for a group whose members see ``most`` others; arguments as the attributes."""
        n_members = len(members)
        return cls(
            members=members,
            squares=squares,
            seen=seen,
            plans=plans,
            x=np.zeros(n_members),
            y=np.zeros(n_members),
            moves=np.zeros(n_members, MOVE),
            body=np.zeros(n_members, np.int64),
            square=np.zeros(n_members, np.int64),
            # Two more than squares, see sort_members.
            starts=np.zeros(squares.columns * squares.rows + 2, np.int64),
            found=np.zeros(n_members, np.int64),
            gap2=np.zeros(n_members),
            nearest=np.zeros(most, np.int64),
            nearest_gap=np.zeros(most),
            lanes=np.zeros(1, DISC_LANES),
        )


def lay_squares(bounds: Floats, n_members: int, reach: float, most: int) -> Squares:
    """Return the squares for a search of so many members within some distance.

    Args:
        bounds: x_min, y_min, x_max, y_max of the world [m].
        n_members: How many members there are.
        reach: How far they see [m].
        most: How many others they see.
    """
    x0, y0, x1, y1 = bounds.tolist()
    width, height = x1 - x0, y1 - y0
    # A square holds (most + 1) / 2 members on average, so the first ring of 3 x 3 squares mostly holds enough.
    side = min(reach, np.sqrt(0.5 * (most + 1.0) * width * height / max(n_members, 1)))
    # A single square: every ring holds all members.
    if n_members < FEW or most == 0 or side == 0.0:
        return Squares(x0, y0, max(width, height), 1, 1, reach)
    # No more squares than members.
    columns = min(max(1, int(width / side)), n_members)
    rows = min(max(1, int(height / side)), max(1, n_members // columns))
    # Rounding must not put a member one square too far away for its distance.
    side = max(side, width / columns, height / rows) * ROUNDING
    return Squares(x0, y0, side, columns, rows, side / ROUNDING)


@kernel
def sort_members(model: Model, state: State, w: int, crowd: Crowd) -> None:
    """Write where the members of one world are, square by square, and how they move.

    Members that plan do as they planned, the others as they move.

    Reads: model (present, radius), state (plan, pose, twist), crowd (members, plans, seen, square, squares, starts).
    Writes: crowd (body, moves, square, starts, x, y).
    """
    members, squares, starts, square = crowd.members, crowd.squares, crowd.starts, crowd.square
    pose, radius = state.pose[w], model.radius[row_of(model.radius, w)]
    n_squares = squares.columns * squares.rows
    for place in range(n_squares + 2):
        starts[place] = 0
    for k in range(members.shape[0]):
        b, place = members[k], -1
        if model.present[w, b]:
            place = 0
            if n_squares > 1:
                column = square_of(pose[b, 0], squares.x, squares.side, squares.columns)
                place = square_of(pose[b, 1], squares.y, squares.side, squares.rows) * squares.columns + column
            # A counting sort, counted two places ahead: after the sums, starts[place + 1] is the square's first row,
            # and the second pass below moves it on to the end of the square, which is where the next one begins.
            starts[place + 2] += 1
        square[k] = place
    for place in range(2, n_squares + 2):
        starts[place] += starts[place - 1]
    for k in range(members.shape[0]):
        b, place = members[k], square[k]
        if place < 0:
            continue
        m = starts[place + 1]
        starts[place + 1] += 1
        crowd.body[m] = b
        # At infinity, no search finds a member that only looks.
        crowd.x[m], crowd.y[m] = pose[b, 0] if crowd.seen[b] else np.inf, pose[b, 1]
        move = crowd.moves[m]
        move.vx, move.vy, move.radius = state.twist[w, b, 0], state.twist[w, b, 1], radius[b]
        # Planning members are known by the velocities that they chose, which a drive may not have reached.
        if crowd.plans[b]:
            move.vx, move.vy = state.plan[w, b, 0], state.plan[w, b, 1]


@kernel
def find_nearest(model: Model, ego: Ego, m: int, place: int, reach: float, crowd: Crowd) -> int:
    """Write the nearest members that a member sees, nearest first; return their number.

    The circle in which it looks for them grows until it holds enough of them.

    Reads: model (seen_row, watchers), crowd (body, found, gap2, nearest, nearest_gap, squares, starts, x, y).
    Writes: crowd (found, gap2, nearest, nearest_gap).

    Args:
        model: Says who sees whom.
        ego: The member that looks.
        m: Its number; it does not see itself.
        place: Its square.
        reach: Members this far away or farther are left out [m].
        crowd: ``nearest`` is written.
    """
    ring, n_found, squares, most = 1, 0, crowd.squares, crowd.nearest.shape[0]
    while True:
        # A ring of n squares to each side holds all that is nearer than n sides, wherever in its square the body is.
        within = reach if ring >= max(squares.columns, squares.rows) else min(reach, ring * squares.first_ring)
        n_found = gather(ego, m, place, within, ring, crowd)
        if model.watchers.shape[0] > 1:
            n_found = keep_visible(model, crowd.body[m], n_found, crowd)
        # Members outside of the circle are farther away than all in it, so enough of these are the nearest.
        if n_found >= most or within >= reach:
            return keep_nearest(n_found, crowd)
        ring *= 2


@kernel
def gather(ego: Ego, m: int, place: int, within: float, ring: int, crowd: Crowd) -> int:
    """Write the members in a ring of squares that are nearer than ``within``, in any order; return their number.

    Reads: crowd (squares, starts, x, y).
    Writes: crowd (found, gap2).

    Args:
        ego: The member that looks.
        m: Its number; it does not see itself.
        place: Its square.
        within: Members this far away or farther are left out [m].
        ring: How many squares to each side are looked at.
        crowd: ``found`` and ``gap2`` are written.
    """
    columns, rows, starts = crowd.squares.columns, crowd.squares.rows, crowd.starts
    xs, ys, gap2, bodies = crowd.x, crowd.y, crowd.gap2, crowd.found
    row, limit2, count = place // columns, within * within, 0
    column = place - row * columns
    left, right = max(column - ring, 0), min(column + ring, columns - 1)
    for other_row in range(max(row - ring, 0), min(row + ring, rows - 1) + 1):
        # The squares of a row lie one behind the other, and so do their members.
        for q in range(starts[other_row * columns + left], starts[other_row * columns + right + 1]):
            dx, dy = xs[q] - ego.x, ys[q] - ego.y
            distance2 = dx * dx + dy * dy
            gap2[count], bodies[count] = distance2, q
            # Always written, and kept only if it counts: a branch here would be mispredicted too often.
            count += int(distance2 < limit2) & int(q != m)
    return count


@kernel
def keep_visible(model: Model, b: int, n_found: int, crowd: Crowd) -> int:
    """Keep those found members that body b sees; return their number.

    Reads: model (seen_row, watchers), crowd (body, found, gap2).
    Writes: crowd (found, gap2).
    """
    count = 0
    for i in range(n_found):
        if model.watchers[model.seen_row[crowd.body[crowd.found[i]]], b]:
            crowd.found[count], crowd.gap2[count] = crowd.found[i], crowd.gap2[i]
            count += 1
    return count


@kernel
def keep_nearest(n_found: int, crowd: Crowd) -> int:
    """Write the nearest of the members that were found, nearest first, then by body; return how many are kept.

    ``nearest`` has as many rows as are kept at most.

    Reads: crowd (body, found, gap2, nearest, nearest_gap).
    Writes: crowd (nearest, nearest_gap).
    """
    body, nearest, nearest_gap, bodies, gap2 = crowd.body, crowd.nearest, crowd.nearest_gap, crowd.found, crowd.gap2
    count, most = 0, nearest.shape[0]
    for i in range(n_found):
        m, key, k = bodies[i], gap2[i], count - 1
        # Insertion sort: a free row at the end, or that of the last one if the new one comes before it.
        if count < most:
            count, k = count + 1, count
        elif most == 0 or not comes_first(key, body[m], nearest_gap[k], body[nearest[k]]):
            continue
        while k > 0 and comes_first(key, body[m], nearest_gap[k - 1], body[nearest[k - 1]]):
            nearest[k], nearest_gap[k] = nearest[k - 1], nearest_gap[k - 1]
            k -= 1
        nearest[k], nearest_gap[k] = m, key
    return count


@kernel
def comes_first(gap2: float, b: int, other_gap2: float, other: int) -> bool:
    """Return whether body b is nearer than another one; of two that are equally near the lower number is."""
    return gap2 < other_gap2 or (gap2 == other_gap2 and b < other)
