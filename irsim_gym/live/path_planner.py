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
    """Plans around everything that never moves: bodies without a drive, static ones, and the obstacle map.

    Args:
        session: The world's bodies.
        population: For maps, which name the obstacles.
    """

    def __init__(self, session: Session, population: Population) -> None:
        self._session, self._population = session, population

    def path(
        self, start: ArrayLike, goal: ArrayLike, radius: float | None = None, *, resolution: float = FINE
    ) -> Floats | None:
        """Return a shortest way for a disc around everything that never moves, shape ``(n, 2)`` [m].

        The way leads straight from point to point, from start to goal, and the disc touches nothing on it: that is
        tested exactly. It is sought over cells and pulled tight, so that it is 0.1 % or so longer than the shortest
        one, up to 3 % where ways on different sides of something are nearly equally long. Bodies that move, also
        robots that wait for actions, are not in the way.

        Args:
            start: x and y [m], and perhaps more, such as a state; flat or a column.
            goal: Likewise.
            radius: Radius of the disc [m]; by default that of the first robot, about its origin.
            resolution: Side of the cells [m]. A gap that is hardly wider than the disc may be missed, the smaller the
                cells the narrower; they are larger in a world with more than a million.

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
        """Return the world as cells, for planners: occupied where something that never moves touches them.

        Args:
            resolution: Side of a cell [m]; by default the obstacle map's own cells, 0.1 m without one. Where the world
                is no multiple of it, cells are a little larger or smaller.

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
