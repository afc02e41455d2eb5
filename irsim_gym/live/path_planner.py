"""Paths through a world that a script steps, and its map for planners."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.arraytypes import Floats
from irsim_gym.live.grid_map import GridMap, n_cells
from irsim_gym.live.moves import robots
from irsim_gym.live.population import Population
from irsim_gym.live.session import Session
from irsim_gym.paths.queries import FINE, fixed_bodies, free_path, touched_cells

DEFAULT_CELL = 0.1


class PathPlanner:
    """Plans around everything that never moves: bodies without a drive, static bodies, and the obstacle map.

    Args:
        session: Bodies of the world.
        population: For maps, which list the obstacles.
    """

    def __init__(self, session: Session, population: Population) -> None:
        self._session, self._population = session, population

    def path(
        self, start: ArrayLike, goal: ArrayLike, radius: float | None = None, *, resolution: float = FINE
    ) -> Floats | None:
        """Return a shortest path for a disc around everything that never moves, shape ``(n, 2)`` [m].

        The path consists of straight lines from start to goal on which the disc touches nothing, which is tested
        exactly. It is found over cells and pulled tight, so it is about 0.1 % longer than the shortest path, and up to
        3 % if paths on different sides of an obstacle are nearly equally long. Bodies that can move are ignored, also
        robots that wait for actions.

        Args:
            start: x and y [m]; further numbers are ignored, so a state will do; flat or a column.
            goal: Likewise.
            radius: Radius of the disc [m] (default: that of the first robot, about its origin).
            resolution: Side of the cells [m]. A gap that is hardly wider than the disc may be missed; smaller cells
                miss fewer. Cells are larger in a world with more than a million of them.

        Returns:
            The points, None where there is no way: also where the disc cannot stand at the start or at the goal.

        Raises:
            ValueError: A point is none, a number is not finite, the radius is negative, or the resolution not positive.
            UnknownNameError: There is no robot to take the radius from.
        """
        model, state = self._session.simulation.model, self._session.simulation.state
        size = self._own_radius() if radius is None else float(radius)
        if not 0.0 <= size < np.inf or not 0.0 < resolution < np.inf:
            raise ValueError(f"radius must be >= 0 and resolution > 0, got {radius!r} and {resolution!r}")
        ends = point(start, "start"), point(goal, "goal")
        points = free_path(model, state, 0, size, *ends, blocks=fixed_bodies(model, 0), cell=float(resolution))
        return points if len(points) else None

    def _own_radius(self) -> float:
        found = robots(self._session.simulation)
        first = int(found[0]) if len(found) else self._session.roster.index(self._population.robot.name)
        return float(self._session.simulation.model.reach[0, first])

    def get_map(self, resolution: float | None = None) -> GridMap:
        """Return the world as cells for planners. Cells that something touches which never moves are occupied.

        Args:
            resolution: Side of a cell [m] (default: that of the obstacle map, 0.1 m without one). If the size of the
                world is no multiple of it, cells are slightly larger or smaller.

        Raises:
            ValueError: It is not positive, or there would be more than ten million cells.
        """
        scenario, model = self._session.simulation.scenario, self._session.simulation.model
        x_min, y_min, x_max, y_max = map(float, model.bounds)
        if resolution is None and scenario.occupied is not None:
            shape = scenario.occupied.shape[0], scenario.occupied.shape[1]
        else:
            shape = n_cells(x_max - x_min, y_max - y_min, DEFAULT_CELL if resolution is None else resolution)
        touched = touched_cells(model, self._session.simulation.state, 0, shape, blocks=fixed_bodies(model, 0))
        return GridMap(
            width=x_max - x_min,
            height=y_max - y_min,
            resolution=(x_max - x_min) / shape[0] if resolution is None else float(resolution),
            grid=np.where(touched, 100.0, 0.0),
            world_offset=(x_min, y_min),
            obstacle_list=self._population.obstacles,
        )


def point(values: ArrayLike, name: str) -> tuple[float, float]:
    """Return x and y [m] of a point, a pose or a state, flat or a column.

    Raises:
        ValueError: It is none.
    """
    try:
        numbers = np.asarray(values, np.float64).reshape(-1)[:2]
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if len(numbers) < 2 or not np.isfinite(numbers).all():
        raise ValueError(f"{name} must be x and y [m], got {values!r}")
    return float(numbers[0]), float(numbers[1])
