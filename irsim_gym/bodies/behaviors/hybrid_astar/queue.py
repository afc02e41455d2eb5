"""Memory of a search over poses: found poses, the queue, and closed cells."""

from typing import NamedTuple, Self

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Pose
from irsim_gym.base.kernels import kernel

MOST_NODES = 1 << 19
"""Maximum number of poses that a search may find."""
MOST_CLOSED = 1 << 17
"""Maximum number of cells that a search may close."""
PLACES = 262_139
"""Places of the table of cells that are done: a prime, twice as many as are ever taken."""
SCATTER = 7919
"""Distance between the entries of neighbouring cells."""
NOBODY, GAVE_UP = -1, -2
"""No pose, move or cell; no pose, since the memory was full before one was found."""
UNKNOWN = -1.0
"""Distance from obstacles on a move that has not been tested."""


class PoseNodes(NamedTuple):
    """The poses that a search has found; the first axis is the slot, except in a slot's own memory.

    Attributes:
        pose: x, y, heading [m, m, rad], shape ``(MOST_NODES, 3)``.
        cost: Cost of the path to the pose [s], shape ``(MOST_NODES,)``, like the following arrays.
        room: Minimum distance of the body from obstacles on the move to the pose [m], ``UNKNOWN`` until computed.
        parent: The previous pose, ``NOBODY`` for the start.
        move: The move from the previous pose.
        key: The queue: lower bounds of total costs, as a binary heap.
        item: The queue: the poses.
        closed: Numbers of the closed cells, ``NOBODY`` in free entries, shape ``(PLACES,)``.
    """

    pose: Floats
    cost: Floats
    room: Floats
    parent: Ints
    move: Ints
    key: Floats
    item: Ints
    closed: Ints

    @classmethod
    def reserve(cls, n_slots: int) -> Self:
        """Return memory for all slots; it is claimed from the system when used."""
        floats = [np.zeros((n_slots, MOST_NODES)) for _ in range(3)]
        ints = [np.zeros((n_slots, MOST_NODES), np.int64) for _ in range(3)]
        poses, closed = np.zeros((n_slots, MOST_NODES, 3)), np.zeros((n_slots, PLACES), np.int64)
        return cls(poses, floats[0], floats[1], ints[0], ints[1], floats[2], ints[2], closed)


@kernel
def nodes_of(nodes: PoseNodes, slot: int) -> PoseNodes:
    """Return one slot's share of the memory."""
    return PoseNodes(
        nodes.pose[slot], nodes.cost[slot], nodes.room[slot], nodes.parent[slot], nodes.move[slot],
        nodes.key[slot], nodes.item[slot], nodes.closed[slot],
    )  # fmt: skip


@kernel
def note_pose(nodes: PoseNodes, node: int, pose: Pose, cost: float, parent: int, move: int) -> None:
    """Write a pose that was found.

    Writes: nodes.
    """
    nodes.pose[node, 0], nodes.pose[node, 1], nodes.pose[node, 2] = pose
    nodes.cost[node], nodes.room[node], nodes.parent[node], nodes.move[node] = cost, UNKNOWN, parent, move


@kernel
def push(nodes: PoseNodes, size: int, key: float, node: int) -> int:
    """Put a pose into the queue and return its new size.

    Writes: nodes.
    """
    keys, items, k = nodes.key, nodes.item, size
    while k > 0:
        # Binary heap: the entries below k are 2 k + 1 and 2 k + 2, with keys no smaller than its own.
        above = (k - 1) // 2
        if keys[above] <= key:
            break
        keys[k], items[k] = keys[above], items[above]
        k = above
    keys[k], items[k] = key, node
    return size + 1


@kernel
def pop(nodes: PoseNodes, size: int) -> int:
    """Return the pose with the least key and take it out of a queue of some size, which is one smaller afterwards.

    Writes: nodes.
    """
    keys, items = nodes.key, nodes.item
    first, last = items[0], size - 1
    # The last entry fills the gap at the top and sinks to its place.
    key, item, k = keys[last], items[last], 0
    while 2 * k + 1 < last:
        below = 2 * k + 1
        if below + 1 < last and keys[below + 1] < keys[below]:
            below += 1
        if key <= keys[below]:
            break
        keys[k], items[k] = keys[below], items[below]
        k = below
    keys[k], items[k] = key, item
    return int(first)


@kernel
def is_closed(closed: Ints, cell: int) -> bool:
    """Return whether a cell is done."""
    # Open addressing: from the place of its hash on, a cell is in the first free place that it found.
    place = cell * SCATTER % PLACES
    while closed[place] != NOBODY:
        if closed[place] == cell:
            return True
        place = place + 1 if place + 1 < PLACES else 0
    return False


@kernel
def close_cell(closed: Ints, cell: int) -> None:
    """Mark a cell that is not yet done as done.

    Writes: closed.
    """
    place = cell * SCATTER % PLACES
    while closed[place] != NOBODY:
        place = place + 1 if place + 1 < PLACES else 0
    closed[place] = cell
