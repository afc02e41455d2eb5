"""Distances over a grid of free cells from all sources at once (Dijkstra 1959).

Steps lead to 16 neighbours: the eight around a cell and the eight a knight's move away. The straight line of a knight's
move passes between two cells, which must be free, too (``grid`` proves that the line is free then). Without obstacles,
distances over the grid are at most 2.8 % longer than straight ones.

The queue keeps cells in buckets as wide as the shortest step (Dial 1969), so that any order within a bucket is valid.
"""

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Ints, Point
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.paths.clearance import Obstacles, way_is_free
from irsim_gym.simulator.paths.grid import BLOCKED, Grid, Search, centre
from irsim_gym.simulator.paths.reachability import gate

N_BUCKETS = 8
"""Buckets in use at a time: more than the longest step, of sqrt(5) cells, can reach ahead."""
NEXT, PREVIOUS, PARENT = 0, 1, 2
"""Rows of a queue. Each bucket is a circular, doubly linked list of cells; behind those of all cells, the columns
``n_cells`` to ``n_cells + N_BUCKETS - 1`` are the heads of the lists.
"""

STEPS = np.array(
    [[dy, dx] for dy in range(-2, 3) for dx in range(-2, 3) if max(abs(dy), abs(dx)) == 1 or abs(dy * dx) == 2],
    np.int64,
)
"""Rows and columns to the neighbours."""

VIA = np.array([[[int(dy / 2), int(dx / 2)], [dy - int(dy / 2), dx - int(dx / 2)]] for dy, dx in STEPS], np.int64)
"""Rows and columns of the two cells that a step passes (for a short step: the cell itself and the neighbour)."""

LENGTHS = np.sqrt(np.sum(STEPS * STEPS, axis=1))
"""Lengths of the steps in cells."""


@kernel
def clear_field(search: Search) -> None:
    """Make all distances infinite and the queue empty."""
    field, queue = search.field, search.queue
    field[:] = np.inf
    n_cells = field.size
    for k in range(n_cells, n_cells + N_BUCKETS):
        # An empty list: its head is its own neighbour.
        queue[NEXT, k], queue[PREVIOUS, k] = k, k


@kernel
def offer(field: Floats, queue: Ints, node: int, distance: float, parent: int, cell: float) -> None:
    """Put a cell into its bucket if the distance [m] is less than the known one."""
    before_now = field[node]
    if distance >= before_now:
        return
    # The cell is in the bucket of its old distance: out of it. A cell that is done never comes back, as no later
    # distance is less than its own.
    if before_now < np.inf:
        before, after = queue[PREVIOUS, node], queue[NEXT, node]
        queue[NEXT, before], queue[PREVIOUS, after] = after, before
    field[node], queue[PARENT, node] = distance, parent
    # Bucket n holds distances from n to n + 1 cells, modulo N_BUCKETS.
    head = field.shape[0] + int(distance / cell) % N_BUCKETS
    after = queue[NEXT, head]
    queue[NEXT, head], queue[PREVIOUS, node], queue[NEXT, node], queue[PREVIOUS, after] = node, head, after, node


@kernel
def offer_gates(obstacles: Obstacles, radius: float, source: Point, grid: Grid, search: Search) -> None:
    """Offer the free cells around a source [m] that it reaches on a free straight line; their PARENT is -1.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: search.
    """
    blocked, field = search.blocked, search.field.reshape(-1)
    rows, columns = blocked.shape
    for i in range(16):
        row, column = gate(i, source, grid)
        if row < 0 or column < 0 or row >= rows or column >= columns or blocked[row, column] == BLOCKED:
            continue
        place = centre(grid, row, column)
        if way_is_free(obstacles, radius, source, place):
            dx, dy = place[0] - source[0], place[1] - source[1]
            offer(field, search.queue, row * columns + column, np.sqrt(dx * dx + dy * dy), -1, grid.cell)


@kernel
def spread(cell: float, target: int, longest: float, search: Search) -> None:
    """Spread from the cells in the queue until it is empty, or until the surroundings of the target are settled.

    Args:
        cell: Side of a cell [m].
        target: Stop once the cell of this number and all as near as four cells beyond it are settled; -1 for no target.
        longest: Leave out cells through which each way to the target is longer than this [m]. Which ways are found to
            the others does not change by that; inf without a target.
        search: Changed: the distances, and the queue.
    """
    blocked, field, queue = search.blocked, search.field, search.queue
    n_cells, bucket, idle = field.size, 0, 0
    rows, columns = blocked.shape
    walls, distances = blocked.reshape(-1), field.reshape(-1)
    # All buckets empty in a row: nothing is left.
    while idle < N_BUCKETS:
        head = n_cells + bucket % N_BUCKETS
        node = queue[NEXT, head]
        if node == head:
            bucket, idle = bucket + 1, idle + 1
            if target >= 0 and distances[target] < (bucket - 4) * cell:
                return
            continue
        idle = 0
        after = queue[NEXT, node]
        queue[NEXT, head], queue[PREVIOUS, after] = after, head
        if longest < np.inf:
            up, aside = node // columns - target // columns, node % columns - target % columns
            if distances[node] + cell * np.sqrt(float(up * up + aside * aside)) > longest:
                continue
        relax(walls, rows, columns, cell, node, distances, queue)


@kernel
def relax(walls: Bytes, rows: int, columns: int, cell: float, node: int, field: Floats, queue: Ints) -> None:
    """Offer all neighbours of a cell. Compares distances first, because most neighbours are nearer already."""
    row, column, reach = node // columns, node % columns, field[node]
    # Only near the border can a step leave the grid, or wrap into the next row.
    is_inner = 2 <= row < rows - 2 and 2 <= column < columns - 2
    for k in range(STEPS.shape[0]):
        if not is_inner:
            to_row, to_column = row + STEPS[k, 0], column + STEPS[k, 1]
            if to_row < 0 or to_column < 0 or to_row >= rows or to_column >= columns:
                continue
        to, distance = node + STEPS[k, 0] * columns + STEPS[k, 1], reach + LENGTHS[k] * cell
        if distance >= field[to] or walls[to] == BLOCKED:
            continue
        if walls[node + VIA[k, 0, 0] * columns + VIA[k, 0, 1]] == BLOCKED:
            continue
        if walls[node + VIA[k, 1, 0] * columns + VIA[k, 1, 1]] == BLOCKED:
            continue
        offer(field, queue, to, distance, node, cell)
