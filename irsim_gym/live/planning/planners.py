"""IR-SIM's planners on cells, as its scripts use them."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, NoReturn, final

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.planning.grid_map import GridMap, n_cells
from irsim_gym.live.planning.path_planner import point

Node = tuple[int, int]
"""Column and row of a point whose coordinates are multiples of the resolution."""
Step = tuple[int, int]
STRAIGHT: tuple[Step, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))
DIAGONAL: tuple[Step, ...] = ((-1, -1), (-1, 1), (1, -1), (1, 1))
# Of ways of equal length, the order of these decides which one is found.
FIRST: tuple[Step, ...] = ((1, 0), (-1, 0), (0, 1), (1, 1), (-1, 1), (0, -1), (1, -1), (-1, -1))


class _Nodes:
    """The nodes of a map: multiples of the resolution, free where a square around them touches nothing."""

    def __init__(self, env_map: GridMap) -> None:
        import shapely

        self._origin = env_map.world_offset
        self._side = env_map.resolution if env_map.grid_resolution is None else env_map.grid_resolution[0]
        over_world = n_cells(env_map.width, env_map.height, self._side)
        self.shape: tuple[int, ...] = over_world if env_map.grid is None else env_map.grid.shape
        n_columns, n_rows = map(max, over_world, self.shape)
        nodes = np.stack(np.divmod(np.arange(n_columns * n_rows), n_rows), axis=1)
        corners = np.hstack([self._place(nodes) - self._side / 2, self._place(nodes) + self._side / 2])
        self.free = set(map(tuple, nodes[~env_map.collisions(shapely.box(*corners.T))].tolist()))

    def _place(self, nodes: ArrayLike) -> Floats:
        return np.asarray(np.asarray(nodes) * self._side + self._origin, np.float64)

    def at(self, values: ArrayLike, name: str) -> Node:
        """Return the node that is nearest to a point."""
        x, y = point(values, name)
        return round((x - self._origin[0]) / self._side), round((y - self._origin[1]) / self._side)

    def places(self, nodes: Iterable[Node]) -> Floats:
        """Return x and y of nodes [m], shape ``(2, n)``."""
        return self._place(list(nodes)).T


def _search(
    start: Node,
    goal: Node,
    successors: Callable[[Node, Step], Iterable[tuple[Node, Step, float]]],
    estimate: Callable[[int, int], float],
) -> list[Node]:
    """Return the nodes from the goal back to the start that A* finds; none without a way, or if both are the same.

    Of nodes that are equally promising, the one that was reached first goes first.

    Args:
        start: The first node.
        goal: The last node.
        successors: Gives, for a node and the step that led there, the nodes that follow, with step and length [cells].
        estimate: Length of the rest [cells], for its columns and rows.
    """
    length, arrival, order, parent = {start: 0.0}, {start: (0, 0)}, {start: 0}, {}
    closed: set[Node] = set()
    queue = [(0.0, 0, start)]
    while queue:
        _, _, node = heapq.heappop(queue)
        if node in closed:
            continue
        if node == goal:
            break
        closed.add(node)
        for other, step, distance in successors(node, arrival[node]):
            total = length[node] + distance
            if other in closed or total >= length.get(other, math.inf):
                continue
            length[other], arrival[other], parent[other] = total, step, node
            rest = estimate(abs(goal[0] - other[0]), abs(goal[1] - other[1]))
            heapq.heappush(queue, (total + rest, order.setdefault(other, len(order)), other))
    way = [goal] if goal in parent else []
    while way and way[-1] in parent:
        way.append(parent[way[-1]])
    return way


def _missing(planner: object, name: str) -> NoReturn:
    message = f"a planner has no '{name}': planning(start, goal) is all it does, env_map is the map"
    raise AttributeError(message, name=name, obj=planner)


@final
class AStarPlanner:
    """The shortest way in straight and diagonal steps over free cells, as IR-SIM's A* finds it.

    Ways are for a point; for a robot with a size, use ``world.path``.

    Args:
        env_map: Result of ``world.get_map``.
    """

    def __init__(self, env_map: GridMap) -> None:
        self.env_map = env_map

    if not TYPE_CHECKING:
        __getattr__ = _missing

    def planning(self, start_pose: ArrayLike, goal_pose: ArrayLike, show_animation: bool = True) -> Floats:
        """Return the way from the goal back to the start, shape ``(2, n)`` [m].

        Its points are multiples of the resolution from the lower left corner of the world; a square of one cell around
        each of them is free. The first and the last are those nearest to goal and start. Without a way, and if both are
        the same point, the goal is the only point.

        Args:
            start_pose: x, y and perhaps more [m], flat or a column.
            goal_pose: Likewise.
            show_animation: Ignored: nothing is shown.

        Raises:
            ValueError: A point is none, or there are too many cells.
        """
        nodes = _Nodes(self.env_map)
        start, goal = nodes.at(start_pose, "start_pose"), nodes.at(goal_pose, "goal_pose")

        def successors(node: Node, _: Step) -> Iterable[tuple[Node, Step, float]]:
            for dx, dy in (*STRAIGHT, *DIAGONAL):
                other = node[0] + dx, node[1] + dy
                if other in nodes.free:
                    yield other, (dx, dy), math.sqrt(2) if dx and dy else 1.0

        return nodes.places(_search(start, goal, successors, math.hypot) or [goal])


@final
class JPSPlanner:
    """A way in straight and diagonal steps over free cells, as IR-SIM's jump point search finds it.

    It is not always the shortest one. Ways are for a point; for a robot with a size, use ``world.path``.

    Args:
        env_map: Result of ``world.get_map``.
    """

    def __init__(self, env_map: GridMap) -> None:
        self.env_map = env_map

    if not TYPE_CHECKING:
        __getattr__ = _missing

    def planning(self, start_pose: ArrayLike, goal_pose: ArrayLike, show_animation: bool = True) -> Floats | None:
        """Return the way from the goal back to the start, shape ``(2, n)`` [m]; see ``AStarPlanner.planning``.

        Args:
            start_pose: x, y and perhaps more [m], flat or a column.
            goal_pose: Likewise.
            show_animation: Ignored: nothing is shown.

        Returns:
            The points; None without a way, also where start or goal is outside or not free, and if both are the same.

        Raises:
            ValueError: A point is none, or there are too many cells.
        """
        nodes = _Nodes(self.env_map)
        start, goal = nodes.at(start_pose, "start_pose"), nodes.at(goal_pose, "goal_pose")
        jumps = _Jumps(nodes, goal)
        if not {start, goal} <= jumps.free:
            return None
        way = _search(start, goal, jumps.successors, _octile)
        if not way:
            return None
        dense = []
        for (x, y), (column, row) in itertools.pairwise(way):
            n_steps = max(abs(column - x), abs(row - y))
            dx, dy = (column - x) // n_steps, (row - y) // n_steps
            dense += [(x + k * dx, y + k * dy) for k in range(n_steps)]
        return nodes.places([*dense, start])


def _octile(columns: int, rows: int) -> float:
    # IR-SIM's estimate, which exceeds the length of the rest: the way may be longer than the shortest one.
    return columns + rows + (math.sqrt(2) - 1) * min(columns, rows)


class _Jumps:
    """Jump points on the way to a goal: where a straight or diagonal run over free nodes has to turn."""

    def __init__(self, nodes: _Nodes, goal: Node) -> None:
        self._shape, self._goal = nodes.shape, goal
        self.free = {node for node in nodes.free if self._is_inside(*node)}

    def _is_inside(self, column: int, row: int) -> bool:
        return 0 <= column < self._shape[0] and 0 <= row < self._shape[1]

    def successors(self, node: Node, arrival: Step) -> Iterable[tuple[Node, Step, float]]:
        """Yield the jump points that follow a node, with the step towards each and its distance [cells]."""
        x, y = node
        around = [step for beside, step in _turns(arrival) if self._is_blocked(node, beside)]
        for dx, dy in (*_onward(arrival), *around):
            other = self._jump(x, y, dx, dy)
            if other is not None:
                yield other, (dx, dy), math.hypot(other[0] - x, other[1] - y)

    def _is_blocked(self, node: Node, beside: Step) -> bool:
        place = node[0] + beside[0], node[1] + beside[1]
        return self._is_inside(*place) and place not in self.free

    def _jump(self, x: int, y: int, dx: int, dy: int) -> Node | None:
        """Return the next jump point in a direction, None if the run ends at the first node."""
        while (node := (x + dx, y + dy)) in self.free:
            x, y = node
            is_turn = node == self._goal or any(self._is_blocked(node, beside) for beside, _ in _turns((dx, dy)))
            if is_turn or (dx and dy and (self._jump(x, y, dx, 0) or self._jump(x, y, 0, dy)) is not None):
                return node
            if (x + dx, y + dy) not in self.free:  # IR-SIM stops in front of a wall
                return node
        return None


def _onward(arrival: Step) -> tuple[Step, ...]:
    """Return the steps that go on from a node without a turn around something: all from the start."""
    dx, dy = arrival
    if not (dx or dy):
        return FIRST
    return ((dx, 0), (0, dy), (dx, dy)) if dx and dy else ((dx, dy),)


def _turns(arrival: Step) -> tuple[tuple[Step, Step], ...]:
    """Return steps around something, each with where it has to be: relative to the node, in IR-SIM's order."""
    dx, dy = arrival
    if dx and dy:
        return ((-dx, 0), (-dx, dy)), ((0, -dy), (dx, -dy))
    if dx:
        return ((0, 1), (dx, 1)), ((0, -1), (dx, -1))
    return (((1, 0), (1, dy)), ((-1, 0), (-1, dy))) if dy else ()
