"""Cheapest paths to one cell of a grid, and lower bounds of the costs from all other cells, as whole numbers.

Steps lead to the eight neighbours. A step costs 5, a diagonal step 7, and ``TIGHT_FACTOR`` times that from a cell in
which a body of the given radius does not fit at the centre. Cells in which it fits nowhere are blocked.

Costs start as if all cells were free. A path is followed from a cell to a neighbour that explains its cost. Without
such a neighbour, the cost is raised to the least that the neighbours allow, and the path continues from the previous
cell (learning depth-first search, Bonet and Geffner 2005). As long as levels only rise, costs never become too high,
wherever the next path begins, so most paths are followed without a raise. If many raises are needed, as in a large
trap, a wave spreads from the end over all cells instead, nearest cells first. Four queues, one for each cost of a step,
hold it: what enters a queue is never cheaper than its content.
"""

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Ints, Labels
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.paths.grid import BLOCKED, FREE

TIGHT = np.uint8(2)
"""Level of a cell in which the body fits, but not at the centre; the others are ``FREE`` and ``BLOCKED``."""
STRAIGHT, ACROSS, TIGHT_FACTOR = 5, 7, 8
"""Costs of a straight and of a diagonal step (7 / 5 is close to the root of 2), and the factor for tight cells."""
NEVER = np.int32(2**30)
"""Cost of a cell without a path."""
HEAD, TAIL, FIRST = 0, 1, 2
"""Where a row of queues keeps the place of its first entry and that behind its last one, and where entries begin."""
BITS = 21
"""An entry of a queue holds the number of a cell in its lowest bits, and the cost in the higher bits."""
ROWS, COLUMNS = np.array([0, 0, 1, -1, 1, 1, -1, -1]), np.array([1, -1, 0, 0, 1, -1, 1, -1])
"""Offsets in rows and columns to the neighbours, those that share a side first."""


def new_queues(rows: int, columns: int) -> Ints:
    """Return scratch memory for ``spread_costs``, shape ``(4, 4 n_cells + 2)``."""
    return np.zeros((4, 4 * rows * columns + FIRST), np.int64)


@kernel
def block_border(levels: Bytes) -> None:
    """Make all cells free, but those at the border blocked."""
    rows, columns = levels.shape
    levels[:] = FREE
    for i in range(rows):
        levels[i, 0], levels[i, columns - 1] = BLOCKED, BLOCKED
    for j in range(columns):
        levels[0, j], levels[rows - 1, j] = BLOCKED, BLOCKED


@kernel
def narrow(levels: Bytes, x: float, y: float, reach: float) -> None:
    """Write which cells are blocked or tight for a body because of an obstacle at a point.

    Writes: levels.

    Args:
        levels: ``FREE``, ``BLOCKED`` or ``TIGHT``, shape ``(rows, columns)``.
        x: The point [cells].
        y: The point [cells].
        reach: Radius of the body [cells].
    """
    rows, columns = levels.shape
    own_row, own_column = int(np.floor(y)), int(np.floor(x))
    for i in range(max(int(np.ceil(y - reach - 0.5)), 0), min(int(np.floor(y + reach - 0.5)) + 1, rows)):
        for j in range(max(int(np.ceil(x - reach - 0.5)), 0), min(int(np.floor(x + reach - 0.5)) + 1, columns)):
            dx, dy = abs(j + 0.5 - x), abs(i + 0.5 - y)
            # The farthest corner of the cell is within reach: so is every place in it.
            if (dx + 0.5) * (dx + 0.5) + (dy + 0.5) * (dy + 0.5) <= reach * reach:
                levels[i, j] = BLOCKED
            elif dx * dx + dy * dy < reach * reach and levels[i, j] == FREE:
                levels[i, j] = TIGHT
    if 0 <= own_row < rows and 0 <= own_column < columns:
        levels[own_row, own_column] = BLOCKED


@kernel
def begin_costs(source: int, least: Labels) -> None:
    """Write the costs of paths to a cell as if all cells were free.

    Writes: least.
    """
    rows, columns = least.shape
    for i in range(rows):
        up = abs(i - source // columns)
        for j in range(columns):
            aside = abs(j - source % columns)
            # As many diagonal steps as the shorter offset allows, the rest straight.
            least[i, j] = STRAIGHT * max(up, aside) + (ACROSS - STRAIGHT) * min(up, aside)


@kernel
def spread_costs(levels: Bytes, source: int, queues: Ints, least: Labels) -> None:
    """Write the cost of the path from each cell, ``NEVER`` if there is none.

    Writes: queues, least.

    Args:
        levels: ``FREE``, ``BLOCKED`` or ``TIGHT``, shape ``(rows, columns)``, blocked at the border.
        source: Number of the cell to which the paths lead, at any level; not at the border.
        queues: Scratch, see ``new_queues``.
        least: Written: the costs, shape ``(rows, columns)``.
    """
    walls, costs, columns = levels.reshape(-1), least.reshape(-1), levels.shape[1]
    begin_wave(source, queues, costs)
    cell = next_cell(queues, costs)
    while cell >= 0:
        offer_neighbours(walls, columns, cell, queues, costs)
        cell = next_cell(queues, costs)


@kernel
def begin_wave(source: int, queues: Ints, costs: Labels) -> None:
    """Begin a wave at a cell, for ``next_cell``.

    Writes: queues, costs.
    """
    costs[:] = NEVER
    costs[source] = 0
    for q in range(4):
        queues[q, HEAD], queues[q, TAIL] = FIRST, FIRST
    queues[0, FIRST], queues[0, TAIL] = source, FIRST + 1


@kernel(inlined=True)
def next_cell(queues: Ints, costs: Labels) -> int:
    """Return the number of the next cell of a wave, the nearest of those that are left; -1 if none is left.

    The cost of that cell is final. The wave goes on from it with ``offer_neighbours``.

    Writes: queues.
    """
    # Every queue is in order, as all its steps cost the same; the least entry is at the head of one of them.
    while True:
        best, chosen = np.int64(2**62), -1
        for q in range(4):
            head = queues[q, HEAD]
            if head < queues[q, TAIL] and queues[q, head] < best:
                best, chosen = queues[q, head], q
        if chosen < 0:
            return -1
        queues[chosen, HEAD] += 1
        cell = int(best & (2**BITS - 1))
        # Else the cell was reached at a lower cost after this entry was made.
        if best >> BITS == costs[cell]:
            return cell


@kernel(inlined=True)
def offer_neighbours(walls: Bytes, columns: int, cell: int, queues: Ints, costs: Labels) -> None:
    """Put the neighbours of a cell whose cheapest path so far leads through it into the queues.

    Writes: costs, queues.
    """
    cost = int(costs[cell])
    for k in range(8):
        aside, along = COLUMNS[k], ROWS[k] * columns
        there = cell + aside + along
        # Most neighbours are nearer already.
        if cost + STRAIGHT >= costs[there] or walls[there] == BLOCKED:
            continue
        # One queue for each cost of a step: straight or diagonal, from a free or a tight cell.
        q = (1 if k >= 4 else 0) + (2 if walls[there] == TIGHT else 0)
        # The path comes from there to here, so the level of that cell counts.
        total = cost + (ACROSS if k >= 4 else STRAIGHT) * (TIGHT_FACTOR if q >= 2 else 1)
        if total >= costs[there]:
            continue
        # No cutting of corners: both cells beside a diagonal step must not be blocked.
        if k >= 4 and (walls[cell + aside] == BLOCKED or walls[cell + along] == BLOCKED):
            continue
        costs[there] = total
        queues[q, queues[q, TAIL]] = (total << BITS) + there
        queues[q, TAIL] += 1


@kernel
def follow_costs(levels: Bytes, least: Labels, start: int, way: Labels) -> int:
    """Write the indices of the cells on a cheapest path from a cell; return their number, 0 without a path.

    It gives up and returns 0 after as many raises as a quarter of the cells. If there is no path and it does not give
    up, ``least`` becomes ``NEVER`` at the start.

    Writes: least, way.

    Args:
        levels: ``FREE``, ``BLOCKED`` or ``TIGHT``, shape ``(rows, columns)``, blocked at the border.
        least: What ways cost at least, shaped as ``levels``: 0 where they end, from ``begin_costs`` or
            ``spread_costs``, and not written since but by this function; levels have only risen since.
        start: Number of the cell, which is not blocked.
        way: Written, room for all cells.
    """
    walls, costs, columns = levels.reshape(-1), least.reshape(-1), levels.shape[1]
    cell, count, raises = start, 1, costs.shape[0] // 4
    way[0] = start
    while 0 < costs[cell] < NEVER:
        weight, onward, best = (TIGHT_FACTOR if walls[cell] == TIGHT else 1), -1, int(NEVER)
        for k in range(8):
            aside, along = COLUMNS[k], ROWS[k] * columns
            there = cell + aside + along
            total = costs[there] + (ACROSS if k >= 4 else STRAIGHT) * weight
            # A blocked cell can only be the end of a path, at cost 0.
            if total >= best or (walls[there] == BLOCKED and costs[there] > 0):
                continue
            if k < 4 or not (walls[cell + aside] == BLOCKED or walls[cell + along] == BLOCKED):
                best, onward = total, there
                # Explains the cost: no neighbour can be cheaper, as costs are lower bounds.
                if total <= costs[cell]:
                    break
        if best > costs[cell]:
            # A raise, and back to the cell before, whose cost may now be too low in turn.
            costs[cell], raises, count = best, raises - 1, max(count - 1, 1)
            cell = int(way[count - 1])
            if raises < 0:
                return 0
        else:
            cell = onward
            way[count] = cell
            count += 1
    return count if costs[cell] == 0 else 0
