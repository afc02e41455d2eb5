"""IR-SIM's planners on cells, as its scripts use them."""

from __future__ import annotations

from abc import ABC
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn, final

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.planning.cell_search import Node, search
from irsim_gym.live.planning.grid_map import GridMap, n_cells
from irsim_gym.live.planning.path_planner import point


class _Nodes:
    """The nodes of a map: multiples of the resolution, free where a square around them touches nothing."""

    def __init__(self, env_map: GridMap) -> None:
        import shapely

        self._origin = env_map.world_offset
        self._side = env_map.resolution if env_map.grid_resolution is None else env_map.grid_resolution[0]
        over_world = n_cells(env_map.width, env_map.height, self._side)
        shape = over_world if env_map.grid is None else env_map.grid.shape
        n_columns, n_rows = map(max, over_world, shape)
        nodes = np.stack(np.divmod(np.arange(n_columns * n_rows), n_rows), axis=1)
        corners = np.hstack([self._place(nodes) - self._side / 2, self._place(nodes) + self._side / 2])
        self.free = set(map(tuple, nodes[~env_map.collisions(shapely.box(*corners.T))].tolist()))
        self.inside = {node for node in self.free if node[0] < shape[0] and node[1] < shape[1]}

    def _place(self, nodes: ArrayLike) -> Floats:
        return np.asarray(np.asarray(nodes) * self._side + self._origin, np.float64)

    def at(self, values: ArrayLike, name: str) -> Node:
        """Return the node that is nearest to a point."""
        x, y = point(values, name)
        return round((x - self._origin[0]) / self._side), round((y - self._origin[1]) / self._side)

    def places(self, nodes: Iterable[Node]) -> Floats:
        """Return x and y of nodes [m], shape ``(2, n)``."""
        return self._place(list(nodes)).T


@dataclass(eq=False, repr=False)
class MapPlanner(ABC):
    """A planner of IR-SIM.

    Attributes:
        env_map: Result of ``world.get_map``.
    """

    env_map: GridMap

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> NoReturn:
            message = f"a planner has no '{name}': planning(start, goal) is all it does, env_map is the map"
            raise AttributeError(message, name=name, obj=self)


@final
class AStarPlanner(MapPlanner):
    """The shortest way in straight and diagonal steps over free cells, as IR-SIM's A* finds it.

    Ways are for a point; for a robot with a size, use ``world.path``.

    Args:
        env_map: Result of ``world.get_map``.
    """

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

        return nodes.places(search(start, goal, nodes.free) or [goal])


@final
class JPSPlanner(MapPlanner):
    """The shortest way in straight and diagonal steps over free cells, which IR-SIM's jump point search may miss.

    Ways are for a point; for a robot with a size, use ``world.path``.

    Args:
        env_map: Result of ``world.get_map``.
    """

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
        way = search(start, goal, nodes.inside) if {start, goal} <= nodes.inside else []
        return nodes.places(way) if way else None
