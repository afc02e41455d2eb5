"""Memory of a search over poses: the poses, the queue, and closed cells."""

from typing import NamedTuple, Self

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Pose, Record, Records
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import record_type

MOST_NODES = 1 << 18
"""Maximum number of poses that a search may find."""
MOST_CLOSED = 1 << 16
"""Maximum number of cells that a search may close."""
PLACES = 131_071
"""Places of the table of cells that are done: a prime, twice as many as are ever taken."""
SCATTER = 7919
"""Distance between the entries of neighbouring cells."""
NOBODY, GAVE_UP = -1, -2
"""No pose or cell; no pose, since the memory was full before one was found."""
UNKNOWN = -1.0
"""Distance from obstacles on a move that has not been tested."""
NODE = record_type("x y heading cost room ahead turn seconds", gear=np.int64, parent=np.int64, ends=np.bool_)
"""A pose [m, m, rad], the cost of the path to it [s], its distance from obstacles [m], ``UNKNOWN`` until computed, the
move that leads to it, as ``MOVE``, of gear 0 at the start, the number of the pose before it, ``NOBODY`` at the start,
and whether the move leads straight to the goal."""


class PoseMemory(NamedTuple):
    """The memory of a search; of all slots, each array has an axis for them in front.

    Attributes:
        nodes: The poses, records of type ``NODE``, shape ``(MOST_NODES,)``.
        key: The queue: lower bounds of total costs, as a binary heap, shape ``(MOST_NODES,)``.
        item: The queue: the numbers of the poses, likewise.
        closed: Numbers of the closed cells, ``NOBODY`` in free entries, shape ``(PLACES,)``.
    """

    nodes: Records
    key: Floats
    item: Ints
    closed: Ints

    @classmethod
    def reserve(cls, n_slots: int) -> Self:
        """Return memory for all slots; it is claimed from the system when used."""
        shape = n_slots, MOST_NODES
        return cls(
            np.zeros(shape, NODE), np.zeros(shape), np.zeros(shape, np.int64), np.zeros((n_slots, PLACES), np.int64)
        )


@kernel
def pose_of(node: Record) -> Pose:
    """Return the pose of a record."""
    return node.x, node.y, node.heading


@kernel
def push(memory: PoseMemory, size: int, key: float, node: int) -> int:
    """Put a pose into the queue and return its new size.

    Writes: memory.
    """
    keys, items, k = memory.key, memory.item, size
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
def pop(memory: PoseMemory, size: int) -> int:
    """Return the pose with the least key and take it out of a queue of some size, which is one smaller afterwards.

    Writes: memory.
    """
    keys, items = memory.key, memory.item
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
