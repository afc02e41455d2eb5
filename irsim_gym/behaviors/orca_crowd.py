"""The members of an ORCA group where they are now, laid side by side by square, and the search for the nearest ones.

A square grid lies over the world. What lies outside of it is put into the nearest square at its border, so nothing is
ever missed. A search looks at a ring of squares about its own, and at wider ones until it has found enough.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.behaviors.orca_lines import LANE_ROWS, LANES
from irsim_gym.geometry.buckets import square_of
from irsim_gym.jit import kernel

FEW = 32
"""So few members are looked through one by one."""

ROUNDING = 1.0 + 1e-9
"""By this much a square is wider than what a ring of squares promises to hold."""


class Crowd(NamedTuple):
    """Memory of one shard for the members of one world.

    Attributes:
        places: x, y of each member that is there, square by square; infinite for one that nobody sees [m].
        moves: vx, vy, radius of the same ones [m/s, m].
        body: Which body each of them is.
        square: Square of each member of the group, -1 for one that is absent.
        starts: First of the members in each square.
        found: Members that a search found.
        gap2: Their squared distances [m2].
        nearest: The nearest of them, nearest first.
        nearest_gap: Their squared distances [m2].
        lanes: What ``disc_planes`` reads and writes.
    """

    places: Floats
    moves: Floats
    body: Ints
    square: Ints
    starts: Ints
    found: Ints
    gap2: Floats
    nearest: Ints
    nearest_gap: Floats
    lanes: Floats


def lay_squares(bounds: Floats, n_members: int, reach: float, most: int) -> Floats:
    """Return the squares for a search of so many members within some distance.

    Args:
        bounds: x_min, y_min, x_max, y_max of the world [m].
        n_members: How many members there are.
        reach: How far they see [m].
        most: How many others they see.

    Returns:
        x, y, side [m], columns, rows, and the distance up to which the first ring of squares holds all [m].
    """
    x0, y0, x1, y1 = bounds.tolist()
    width, height = x1 - x0, y1 - y0
    side = min(reach, np.sqrt(0.5 * (most + 1.0) * width * height / max(n_members, 1)))
    if n_members < FEW or most == 0 or side == 0.0:
        return np.array([x0, y0, max(width, height), 1.0, 1.0, reach])
    columns = min(max(1, int(width / side)), n_members)
    rows = min(max(1, int(height / side)), max(1, n_members // columns))
    side = max(side, width / columns, height / rows) * ROUNDING
    return np.array([x0, y0, side, columns, rows, side / ROUNDING])


def reserve(n_slots: int, n_members: int, most: int, n_squares: int) -> dict[str, Any]:
    """Return the arrays of ``Crowd`` for each slot."""
    return {
        "places": np.zeros((n_slots, 2, n_members)),
        "moves": np.zeros((n_slots, n_members, 3)),
        "body": np.zeros((n_slots, n_members), np.int64),
        "square": np.zeros((n_slots, n_members), np.int64),
        "starts": np.zeros((n_slots, n_squares + 2), np.int64),
        "found": np.zeros((n_slots, n_members), np.int64),
        "gap2": np.zeros((n_slots, n_members)),
        "nearest": np.zeros((n_slots, most), np.int64),
        "nearest_gap": np.zeros((n_slots, most)),
        "lanes": np.zeros((n_slots, LANE_ROWS * LANES)),
    }


@kernel
def sort_members(
    members: Ints,
    squares: Floats,
    seen: Flags,
    plans: Flags,
    present: Flags,
    radii: Floats,
    pose: Floats,
    plan: Floats,
    twist: Floats,
    crowd: Crowd,
) -> None:
    """Write where the members of one world are, square by square, and how they move.

    Members that plan do as they planned, the others as they move.

    Args:
        members: Bodies that see or are seen, shape ``(n_members,)``.
        squares: As ``lay_squares`` returns them.
        seen: Who can be seen, shape ``(body,)``.
        plans: Who plans, shape ``(body,)``.
        present: Who exists, shape ``(body,)``.
        radii: Radii [m], shape ``(body,)``.
        pose: x, y, heading [m, m, rad], shape ``(body, 3)``.
        plan: What was planned [m/s], shape ``(body, 2)``.
        twist: Velocities [m/s], shape ``(body, 3)``.
        crowd: Written.
    """
    columns, rows, starts, square = int(squares[3]), int(squares[4]), crowd.starts, crowd.square
    for place in range(columns * rows + 2):
        starts[place] = 0
    for k in range(members.shape[0]):
        b, place = members[k], -1
        if present[b]:
            place = 0
            if columns * rows > 1:
                column = square_of(pose[b, 0], squares[0], squares[2], columns)
                place = square_of(pose[b, 1], squares[1], squares[2], rows) * columns + column
            starts[place + 2] += 1
        square[k] = place
    for place in range(2, columns * rows + 2):
        starts[place] += starts[place - 1]
    for k in range(members.shape[0]):
        b, place = members[k], square[k]
        if place < 0:
            continue
        m = starts[place + 1]
        starts[place + 1] += 1
        crowd.body[m] = b
        crowd.places[0, m], crowd.places[1, m] = pose[b, 0] if seen[b] else np.inf, pose[b, 1]
        vx, vy = (plan[b, 0], plan[b, 1]) if plans[b] else (twist[b, 0], twist[b, 1])
        crowd.moves[m, 0], crowd.moves[m, 1], crowd.moves[m, 2] = vx, vy, radii[b]


@kernel
def gather(
    own: int,
    x: float,
    y: float,
    within: float,
    ring: int,
    column: int,
    row: int,
    columns: int,
    rows: int,
    starts: Ints,
    places: Floats,
    gap2: Floats,
    found: Ints,
) -> int:
    """Write the members in a ring of squares that are nearer than ``within``, in any order; return their number.

    Args:
        own: The member that looks; it does not see itself.
        x: Where it is [m].
        y: Where it is [m].
        within: Members this far away or farther are left out [m].
        ring: How many squares to each side are looked at.
        column: The square of the member that looks.
        row: Likewise.
        columns: Number of squares.
        rows: Likewise.
        starts: First member of each square.
        places: x, y of the members [m], shape ``(2, n_members)``.
        gap2: Written: squared distances [m2], shape ``(n_members,)``.
        found: Written: numbers of members, shape ``(n_members,)``.
    """
    limit2, count = within * within, 0
    left, right = max(column - ring, 0), min(column + ring, columns - 1)
    for other_row in range(max(row - ring, 0), min(row + ring, rows - 1) + 1):
        for m in range(starts[other_row * columns + left], starts[other_row * columns + right + 1]):
            dx, dy = places[0, m] - x, places[1, m] - y
            distance2 = dx * dx + dy * dy
            gap2[count], found[count] = distance2, m
            count += int(distance2 < limit2) & int(m != own)  # without a branch that nobody can foresee
    return count


@kernel
def keep_nearest(n_found: int, gap2: Floats, found: Ints, body: Ints, nearest_gap: Floats, nearest: Ints) -> int:
    """Write the nearest of the members that were found, nearest first, then by body; return how many are kept.

    ``nearest`` has as many rows as are kept at most.
    """
    count, most = 0, nearest.shape[0]
    for i in range(n_found):
        m, key, k = found[i], gap2[i], count - 1
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
