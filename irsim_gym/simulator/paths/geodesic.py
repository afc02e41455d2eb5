"""Shortest paths of a disc, and the field of distances to a goal."""

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Point
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.paths.clearance import Obstacles, way_is_free
from irsim_gym.simulator.paths.grid import BLOCKED, Grid, Search, centre, mark_blocked
from irsim_gym.simulator.paths.pulling import pull
from irsim_gym.simulator.paths.reachability import gate
from irsim_gym.simulator.paths.spread import PARENT, clear_field, offer_gates, spread

DETOUR = 1.1
"""Ways that are longer than straight ones by this factor are sought among all cells, shorter ones in an ellipse."""
NEAR = 8.0
"""A way to the target through another gate of the start is longer than the direct one by less than this [cells], if
that gate is the best: it is at most 2 sqrt(2) farther from the goal, and at most 3 sqrt(2) from the target.
"""
RINGS = 2
"""Number of rings of blocked cells into which ``distance_field`` continues."""


@kernel
def shortest_path(
    obstacles: Obstacles, radius: float, start: Point, goal: Point, grid: Grid, search: Search, path: Floats
) -> int:
    """Write a short free path and return its number of points, 0 if there is none.

    This is the straight path if it is free, else the shortest path over free cells, pulled tight. Every written path is
    free (tested exactly), so it is never shorter than the true shortest path. It is usually about 0.1 % longer; up to 3
    % if paths on different sides of an obstacle are nearly equally long, and more if a gap is too narrow for the cells
    (see ``is_reachable``).

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: search, path.

    Args:
        obstacles: What is in the way.
        radius: Radius of the moving body [m].
        start: Where it starts [m].
        goal: Where it goes [m].
        grid: The grid.
        search: Scratch.
        path: Written: the points from start to goal [m], as from ``Grid.path``.
    """
    path[0, 0], path[0, 1], path[1, 0], path[1, 1] = start[0], start[1], goal[0], goal[1]
    if way_is_free(obstacles, radius, start, goal):
        return 2
    if not way_is_free(obstacles, radius, start, start) or not way_is_free(obstacles, radius, goal, goal):
        return 0
    mark_blocked(obstacles, radius, grid, search.blocked)
    clear_field(search)
    # From the goal, so that the cells' parents lead from start to goal.
    offer_gates(obstacles, radius, goal, grid, search)
    dx, dy = goal[0] - start[0], goal[1] - start[1]
    longest = DETOUR * np.sqrt(dx * dx + dy * dy) + 2.0 * NEAR * grid.cell
    # Any gate at the start will do to end the search; the best one is known when the field about it is settled.
    target = best_gate(obstacles, radius, start, grid, search, False)
    if target < 0:
        return 0
    spread(grid.cell, target, longest, search)
    if search.field.reshape(-1)[target] + NEAR * grid.cell > longest:
        # The way is a long detour, or there is none: from the beginning again, everywhere.
        clear_field(search)
        offer_gates(obstacles, radius, goal, grid, search)
        spread(grid.cell, target, np.inf, search)
    target = best_gate(obstacles, radius, start, grid, search, True)
    if target < 0:
        return 0
    return pull(obstacles, radius, path, trace(target, goal, grid, search.queue, path))


@kernel
def best_gate(obstacles: Obstacles, radius: float, start: Point, grid: Grid, search: Search, settled: bool) -> int:
    """Return the cell near a point [m] through which the path to the goal is shortest, -1 if there is none.

    The point must see the centre of the cell on a free straight line. If the field is not settled, the
    nearest such cell is returned.

    Reads: obstacles (blocks, cells, model, state, w).
    """
    blocked, field = search.blocked, search.field
    rows, columns = blocked.shape
    best, chosen = np.inf, -1
    for i in range(16):
        row, column = gate(i, start, grid)
        if row < 0 or column < 0 or row >= rows or column >= columns or blocked[row, column] == BLOCKED:
            continue
        place = centre(grid, row, column)
        dx, dy = place[0] - start[0], place[1] - start[1]
        total = np.sqrt(dx * dx + dy * dy) + (field[row, column] if settled else 0.0)
        if total < best and way_is_free(obstacles, radius, start, place):
            best, chosen = total, row * columns + column
    return chosen


@kernel
def trace(cell_number: int, goal: Point, grid: Grid, queue: Ints, path: Floats) -> int:
    """Write the centres of the cells from a cell to the source of the path, and return the number of points.

    Points inside straight pieces are left out. The source itself comes last.
    """
    count, last_step = 1, 0
    cell = cell_number
    while cell >= 0:
        onward = queue[PARENT, cell]
        # A change of the step from cell to cell, in the numbers of cells, is a corner.
        if count == 1 or onward < 0 or onward - cell != last_step:
            path[count, 0], path[count, 1] = centre(grid, cell // grid.columns, cell % grid.columns)
            count += 1
        last_step = onward - cell
        cell = onward
    path[count, 0], path[count, 1] = goal[0], goal[1]
    return count + 1


@kernel
def search_ways(obstacles: Obstacles, radius: float, goal: Point, grid: Grid, search: Search) -> None:
    """Write ``search``: the distance to the goal over free cells, and the next cell on the way, for each cell.

    The distance is at most 3 % and some cells longer than the true one.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: search.

    Args:
        obstacles: What is in the way.
        radius: Radius of the moving body [m].
        goal: The goal [m].
        grid: The grid.
        search: Written.
    """
    mark_blocked(obstacles, radius, grid, search.blocked)
    clear_field(search)
    offer_gates(obstacles, radius, goal, grid, search)
    spread(grid.cell, -1, np.inf, search)


@kernel
def distance_field(obstacles: Obstacles, radius: float, goal: Point, grid: Grid, search: Search) -> None:
    """Write what ``search_ways`` writes, and extend ``search.field`` into two rings of blocked cells.

    So a body close to an obstacle reads a finite value.

    Reads: obstacles (blocks, cells, model, state, w).
    Writes: search.
    """
    search_ways(obstacles, radius, goal, grid, search)
    for _ in range(RINGS):
        add_ring(search.field, grid.cell)


@kernel
def add_ring(field: Floats, cell: float) -> None:
    """Give cells without a distance one step more than the smallest distance of their eight neighbours.

    New values stay negative until the end, so that the ring is one cell wide.
    """
    rows, columns = field.shape
    for row in range(rows):
        for column in range(columns):
            if field[row, column] < np.inf:
                continue
            beside, across = np.inf, np.inf
            for side in range(-1, 2, 2):
                # At the border of the grid, indices are clamped to cells that are counted anyway.
                up, aside = min(max(row + side, 0), rows - 1), min(max(column + side, 0), columns - 1)
                other = min(max(column - side, 0), columns - 1)
                beside = min(beside, reached(field[up, column]), reached(field[row, aside]))
                across = min(across, reached(field[up, aside]), reached(field[up, other]))
            best = min(beside + cell, across + np.sqrt(2.0) * cell)
            if best < np.inf:
                field[row, column] = -best
    for row in range(rows):
        for column in range(columns):
            field[row, column] = abs(field[row, column])


@kernel
def reached(distance: float) -> float:
    """Return a distance, inf for one that was new in this ring."""
    return distance if distance >= 0.0 else np.inf


@kernel
def field_at(field: Floats, grid: Grid, x: float, y: float) -> float:
    """Return the distance [m] at a point, interpolated between those of the four surrounding cells that have one.

    Beyond the outermost centres, it is the value at the nearest point between them; inf if no cell has a distance.
    """
    rows, columns = field.shape
    # In cells from the centre of cell 0: the whole part is the cell to the lower left, the rest the share of the next.
    across = min(max((x - grid.origin_x) / grid.cell - 0.5, 0.0), columns - 1.0)
    up = min(max((y - grid.origin_y) / grid.cell - 0.5, 0.0), rows - 1.0)
    column, row = int(across), int(up)
    part_x, part_y = across - column, up - row
    total, weights = 0.0, 0.0
    for i in range(2):
        for j in range(2):
            value = field[min(row + i, rows - 1), min(column + j, columns - 1)]
            weight = (part_y if i == 1 else 1.0 - part_y) * (part_x if j == 1 else 1.0 - part_x)
            if value < np.inf:
                total, weights = total + weight * value, weights + weight
    # Cells without a distance leave their weight to the others.
    return total / weights if weights > 0.0 else np.inf
