"""IR-SIM's planners on cells, as its scripts use them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NoReturn, final

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.arraytypes import Floats
from irsim_gym.live.grid_map import GridMap
from irsim_gym.live.path_planner import point
from irsim_gym.paths.queries import cells_way


@final
class AStarPlanner:
    """Shortest paths over the free cells of a map.

    Paths are for a point; for a robot with a size, use ``world.path``. The search spreads from the goal, which finds
    what A* finds.

    Args:
        env_map: Result of ``world.get_map``.
    """

    def __init__(self, env_map: GridMap) -> None:
        self.env_map = env_map

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> NoReturn:
            message = f"a planner has no '{name}': planning(start, goal) is all it does, env_map holds the cells"
            raise AttributeError(message, name=name, obj=self)

    def planning(self, start_pose: ArrayLike, goal_pose: ArrayLike, show_animation: bool = False) -> Floats | None:
        """Return the path from the goal back to the start, as IR-SIM does, shape ``(2, n)`` [m].

        A step leads from the centre of a cell to that of one of its eight neighbours or a knight's move away, through
        free cells only. It may pass between two occupied cells that meet at a corner. The given points come before the
        first centre and after the last.

        Args:
            start_pose: x, y and perhaps more [m], flat or a column.
            goal_pose: Likewise.
            show_animation: Ignored: nothing is shown.

        Returns:
            The points, None where there is no way: also where start or goal is outside, or in an occupied cell.

        Raises:
            ValueError: A point is none.
        """
        start, goal = point(start_pose, "start_pose"), point(goal_pose, "goal_pose")
        here, there = self.env_map.cell_of(*start), self.env_map.cell_of(*goal)
        if here is None or there is None:
            return None
        blocked = np.ascontiguousarray(self.env_map.occupied.T, np.uint8)
        way = cells_way(blocked, here[::-1], there[::-1])
        if not way:
            return None
        centers = [self.env_map.center_of(column, row) for row, column in reversed(way)]
        return np.array([goal, *centers, start]).T


JPSPlanner = AStarPlanner
"""The same planner, because jump point search finds the same paths."""
