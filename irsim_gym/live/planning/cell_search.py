"""Shortest ways in straight and diagonal steps over cells."""

import heapq
import math
from collections.abc import Set

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.simulator.paths.clearance import Obstacles, way_is_free
from irsim_gym.simulator.paths.grid import FREE, Grid, centre, mark_blocked
from irsim_gym.simulator.paths.reachability import gate

Node = tuple[int, int]
"""Two indices of a cell, or of a point whose coordinates are multiples of a resolution."""
STEPS = ((1, 0), (0, 1), (-1, 0), (0, -1), (-1, -1), (-1, 1), (1, -1), (1, 1))
"""Steps to neighbours. Of ways of equal length, their order decides which one is found."""


def search(start: Node, goal: Node, free: Set[Node]) -> list[Node]:
    """Return the nodes from the goal back to the start that A* finds; none without a way, or if both are the same.

    Of nodes that are equally promising, the one that was reached first goes first.
    """
    length, order, parent = {start: 0.0}, {start: 0}, dict[Node, Node]()
    closed: set[Node] = set()
    queue = [(0.0, 0, start)]
    while queue:
        _, _, node = heapq.heappop(queue)
        if node in closed:
            continue
        if node == goal:
            break
        closed.add(node)
        for dx, dy in STEPS:
            other, total = (node[0] + dx, node[1] + dy), length[node] + math.hypot(dx, dy)
            if other not in free or other in closed or total >= length.get(other, math.inf):
                continue
            length[other], parent[other] = total, node
            rest = math.hypot(goal[0] - other[0], goal[1] - other[1])
            heapq.heappush(queue, (total + rest, order.setdefault(other, len(order)), other))
    way = [goal] if goal in parent else []
    while way and way[-1] in parent:
        way.append(parent[way[-1]])
    return way


def cell_way(
    obstacles: Obstacles, radius: float, start: tuple[float, float], goal: tuple[float, float], grid: Grid
) -> Floats:
    """Return the points of a shortest way of a disc over the centres of free cells, shape ``(n, 2)`` [m].

    It begins and ends with straight lines between a point and the nearest centre. There are no points without a way.
    """
    blocked = grid.blocked()
    mark_blocked(obstacles, radius, grid, blocked)
    free = {(row, column) for row, column in np.argwhere(blocked == FREE).tolist()}
    ends = list[Node]()
    for place in (start, goal):
        centres = {cell: centre(grid, *cell) for cell in (gate(i, place, grid) for i in range(16)) if cell in free}
        near = sorted(centres, key=lambda cell: math.dist(centres[cell], place))
        ends += [cell for cell in near if way_is_free(obstacles, radius, place, centres[cell])][:1]
    way = ends[:1]
    if len(ends) == 2 and ends[0] != ends[1]:
        way = search(ends[0], ends[1], free)
    points = [start, *(centre(grid, *cell) for cell in reversed(way)), goal] if way and len(ends) == 2 else []
    return np.array(points, np.float64).reshape(-1, 2)
