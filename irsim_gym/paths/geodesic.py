"""The shortest way of a body of some radius, and the distance to a goal from everywhere."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Bytes, CellMap, Flags, Floats, Ints
from irsim_gym.jit import kernel
from irsim_gym.paths.clearance import way_is_free
from irsim_gym.paths.grid import BLOCKED, mark_blocked
from irsim_gym.paths.pulling import pull
from irsim_gym.paths.reachability import gate
from irsim_gym.paths.spread import PARENT, clear_field, offer_gates, spread

RINGS = 2
"""How many rings of blocked cells ``distance_field`` continues into."""


@kernel
def shortest_path(
    segments: Floats,
    segment_start: Ints,
    segment_count: Ints,
    discs: Floats,
    disc_start: Ints,
    disc_count: Ints,
    solid: Flags,
    blocks: Flags,
    cells: CellMap | None,
    radius: float,
    start_x: float,
    start_y: float,
    goal_x: float,
    goal_y: float,
    origin_x: float,
    origin_y: float,
    cell: float,
    blocked: Bytes,
    field: Floats,
    queue: Ints,
    path: Floats,
) -> int:
    """Write a short free path and return its number of points, 0 if there is none.

    The straight way if it is free; else the shortest over free cells, pulled tight. What is written is free all the
    way (tested exactly), so its length is never below that of the true shortest path; it is above by 0.1 % or so,
    unless ways on different sides of something are nearly equally long (then by up to 3 %) or a gap is too narrow for
    the cells (see ``is_reachable``).

    Args:
        segments: As all tables up to ``cells``: see the package's description.
        segment_start: See there.
        segment_count: See there.
        discs: See there.
        disc_start: See there.
        disc_count: See there.
        solid: See there.
        blocks: See there.
        cells: See there.
        radius: Radius of the moving body [m].
        start_x: Start [m].
        start_y: Start [m].
        goal_x: Goal [m].
        goal_y: Goal [m].
        origin_x: Lower left corner of the grid [m].
        origin_y: Lower left corner of the grid [m].
        cell: Side of a cell [m].
        blocked: Scratch, shape ``(rows, columns)``.
        field: Scratch, shape ``(rows, columns)``.
        queue: Scratch, as from ``Grid.queue``.
        path: Written: the points from start to goal [m], as from ``Grid.path``.
    """
    outlines = (segments, segment_start, segment_count, discs, disc_start, disc_count, solid, blocks, cells)
    path[0, 0], path[0, 1], path[1, 0], path[1, 1] = start_x, start_y, goal_x, goal_y
    if way_is_free(*outlines, radius, start_x, start_y, goal_x, goal_y):
        return 2
    if not way_is_free(*outlines, radius, start_x, start_y, start_x, start_y):
        return 0
    if not way_is_free(*outlines, radius, goal_x, goal_y, goal_x, goal_y):
        return 0
    mark_blocked(*outlines, radius, origin_x, origin_y, cell, blocked)
    clear_field(field, queue)
    # From the goal, so that the cells' parents lead from start to goal.
    offer_gates(*outlines, radius, goal_x, goal_y, origin_x, origin_y, cell, blocked, field, queue)
    target = best_gate(*outlines, radius, start_x, start_y, origin_x, origin_y, cell, blocked, field, False)
    if target < 0:
        return 0
    columns = field.shape[1]
    spread(blocked, cell, target // columns, target % columns, field, queue)
    target = best_gate(*outlines, radius, start_x, start_y, origin_x, origin_y, cell, blocked, field, True)
    if target < 0:
        return 0
    count = trace(target, columns, origin_x, origin_y, cell, goal_x, goal_y, queue, path)
    return pull(*outlines, radius, path, count)


@kernel
def best_gate(
    segments: Floats,
    segment_start: Ints,
    segment_count: Ints,
    discs: Floats,
    disc_start: Ints,
    disc_count: Ints,
    solid: Flags,
    blocks: Flags,
    cells: CellMap | None,
    radius: float,
    x: float,
    y: float,
    origin_x: float,
    origin_y: float,
    cell: float,
    blocked: Bytes,
    field: Floats,
    settled: bool,
) -> int:
    """Return the number of the cell near (x, y) [m], straight from which the way on is shortest; -1 for none.

    Unless the field is settled, any cell that can be reached straight will do.
    """
    outlines = (segments, segment_start, segment_count, discs, disc_start, disc_count, solid, blocks, cells)
    rows, columns = blocked.shape
    best, found = np.inf, -1
    for i in range(16):
        row, column = gate(i, x - origin_x, y - origin_y, cell)
        if row < 0 or column < 0 or row >= rows or column >= columns or blocked[row, column] == BLOCKED:
            continue
        gate_x, gate_y = origin_x + (column + 0.5) * cell, origin_y + (row + 0.5) * cell
        dx, dy = gate_x - x, gate_y - y
        total = np.sqrt(dx * dx + dy * dy) + (field[row, column] if settled else 0.0)
        if total < best and way_is_free(*outlines, radius, x, y, gate_x, gate_y):
            best, found = total, row * columns + column
    return found


@kernel
def trace(
    cell_number: int,
    columns: int,
    origin_x: float,
    origin_y: float,
    cell: float,
    goal_x: float,
    goal_y: float,
    queue: Ints,
    path: Floats,
) -> int:
    """Write the cells' centres from a cell on to the source behind the path's first point; return how many points.

    Points within straight pieces are left out; the source itself comes last.
    """
    count, last_step = 1, 0
    here = cell_number
    while here >= 0:
        onward = queue[PARENT, here]
        if count == 1 or onward < 0 or onward - here != last_step:
            path[count, 0] = origin_x + (here % columns + 0.5) * cell
            path[count, 1] = origin_y + (here // columns + 0.5) * cell
            count += 1
        last_step = onward - here
        here = onward
    path[count, 0], path[count, 1] = goal_x, goal_y
    return count + 1


@kernel
def distance_field(
    segments: Floats,
    segment_start: Ints,
    segment_count: Ints,
    discs: Floats,
    disc_start: Ints,
    disc_count: Ints,
    solid: Flags,
    blocks: Flags,
    cells: CellMap | None,
    radius: float,
    goal_x: float,
    goal_y: float,
    origin_x: float,
    origin_y: float,
    cell: float,
    blocked: Bytes,
    field: Floats,
    queue: Ints,
) -> None:
    """Write the distance to the goal over free cells for each cell.

    It is at most 3 % and some cells longer than the true one. Two rings of blocked cells next to free ones get a
    distance too, so that a body close to an obstacle reads a finite value.

    Args:
        segments: As all tables up to ``cells``: see the package's description.
        segment_start: See there.
        segment_count: See there.
        discs: See there.
        disc_start: See there.
        disc_count: See there.
        solid: See there.
        blocks: See there.
        cells: See there.
        radius: Radius of the moving body [m].
        goal_x: Goal [m].
        goal_y: Goal [m].
        origin_x: Lower left corner of the grid [m].
        origin_y: Lower left corner of the grid [m].
        cell: Side of a cell [m].
        blocked: Scratch, shape ``(rows, columns)``; holds the blocked cells afterwards.
        field: Written: distance [m], inf where there is no way, shape ``(rows, columns)``.
        queue: Scratch, as from ``Grid.queue``.
    """
    outlines = (segments, segment_start, segment_count, discs, disc_start, disc_count, solid, blocks, cells)
    mark_blocked(*outlines, radius, origin_x, origin_y, cell, blocked)
    clear_field(field, queue)
    offer_gates(*outlines, radius, goal_x, goal_y, origin_x, origin_y, cell, blocked, field, queue)
    spread(blocked, cell, -1, -1, field, queue)
    for _ in range(RINGS):
        add_ring(field, cell)


@kernel
def add_ring(field: Floats, cell: float) -> None:
    """Give cells without a distance one step more than the least of their eight neighbours.

    New values are kept negative until the end, so that the ring is one cell wide.
    """
    rows, columns = field.shape
    for row in range(rows):
        for column in range(columns):
            if field[row, column] < np.inf:
                continue
            beside, across = np.inf, np.inf
            for side in range(-1, 2, 2):
                up, aside = min(max(row + side, 0), rows - 1), min(max(column + side, 0), columns - 1)
                other = min(max(column - side, 0), columns - 1)
                beside = min(beside, known(field[up, column]), known(field[row, aside]))
                across = min(across, known(field[up, aside]), known(field[up, other]))
            best = min(beside + cell, across + np.sqrt(2.0) * cell)
            if best < np.inf:
                field[row, column] = -best
    for row in range(rows):
        for column in range(columns):
            field[row, column] = abs(field[row, column])


@kernel
def known(distance: float) -> float:
    """Return a distance, inf for one that was new in this ring."""
    return distance if distance >= 0.0 else np.inf


@kernel
def field_at(field: Floats, origin_x: float, origin_y: float, cell: float, x: float, y: float) -> float:
    """Return the distance [m] at a point, interpolated between the four cells around it that have one.

    Beyond the outermost centres the value at the nearest point between them holds; inf where no cell has a distance.
    """
    rows, columns = field.shape
    across = min(max((x - origin_x) / cell - 0.5, 0.0), columns - 1.0)
    up = min(max((y - origin_y) / cell - 0.5, 0.0), rows - 1.0)
    column, row = int(across), int(up)
    part_x, part_y = across - column, up - row
    total, weights = 0.0, 0.0
    for i in range(2):
        for j in range(2):
            value = field[min(row + i, rows - 1), min(column + j, columns - 1)]
            weight = (part_y if i == 1 else 1.0 - part_y) * (part_x if j == 1 else 1.0 - part_x)
            if value < np.inf:
                total, weights = total + weight * value, weights + weight
    return total / weights if weights > 0.0 else np.inf
