"""Paths through a world that a script steps, and its map for planners."""

from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import NoEffectWarning, warn_caller
from irsim_gym.live.planning.cell_search import cell_way
from irsim_gym.live.planning.grid_map import COARSER, FINER, GridMap, coarser, n_cells
from irsim_gym.live.planning.sampling import SAMPLERS, Sampling, sampled_way
from irsim_gym.live.population.population import Population
from irsim_gym.live.session.moves import robots
from irsim_gym.live.session.session import Session
from irsim_gym.live.session.vectors import row_of
from irsim_gym.simulator.cell_paths.queries import FINE, fixed_bodies, free_path, obstacles_of, touched_cells
from irsim_gym.simulator.paths.clearance import way_is_free
from irsim_gym.simulator.paths.grid import Grid

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
        self,
        start: ArrayLike,
        goal: ArrayLike,
        radius: float | None = None,
        *,
        resolution: float = FINE,
        method: str = "shortest",
        iterations: int = 1000,
        seed: int = 0,
    ) -> Floats | None:
        """Return a path for a disc around everything that never moves, shape ``(n, 2)`` [m].

        The path consists of straight lines from start to goal on which the disc touches nothing, which is tested
        exactly. Bodies that can move are ignored, also robots that wait for actions.

        - ``shortest`` finds the path over cells and pulls it tight: it is about 0.1 % longer than the shortest path,
          and up to 3 % if paths on different sides of an obstacle are nearly equally long.
        - ``astar`` and ``jps`` return the same: a shortest path in straight and diagonal steps over cells.
        - ``rrt``, ``rrt_star``, ``informed_rrt_star`` and ``prm`` draw points in the world, through OMPL
          (``pip install "irsim_gym[ompl]"``). ``rrt`` ends at its first path, the others shorten it to the end. Where
          gaps are narrow, they may need more iterations.

        Args:
            start: x and y [m]; further numbers are ignored, so a state will do; flat or a column.
            goal: Likewise.
            radius: Radius of the disc [m] (default: that of the first robot, about its origin).
            resolution: Side of the cells [m]. A gap that is hardly wider than the disc may be missed; smaller cells
                miss fewer. Cells are larger in a world with more than a million of them.
            method: How to find the path.
            iterations: Attempts to extend a tree; for ``prm``, the number of points of its road map.
            seed: The same seed draws the same points.

        Returns:
            The points, None where there is no way: also where the disc cannot stand at the start or at the goal.

        Raises:
            ValueError: A point is none, a number is not finite, the radius is negative, the resolution or the number
                of iterations is not positive, or the method is unknown.
            UnknownNameError: There is no robot to take the radius from.
            MissingExtraError: The method needs OMPL, which is not installed.
        """
        model, state = self._session.simulation.model, self._session.simulation.state
        size = self._own_radius() if radius is None else float(radius)
        if not 0.0 <= size < np.inf or not 0.0 < resolution < np.inf:
            raise ValueError(f"radius must be >= 0 and resolution > 0, got {radius!r} and {resolution!r}")
        ends, blocks = (point(start, "start"), point(goal, "goal")), fixed_bodies(model, 0)
        if method == "shortest":
            points = free_path(model, state, 0, size, *ends, blocks=blocks, cell=float(resolution))
        elif method in ("astar", "jps"):
            obstacles = obstacles_of(model, state, 0, blocks)
            points = cell_way(obstacles, size, *ends, Grid.over(model.bounds, float(resolution)))
        elif method in SAMPLERS:
            is_free = partial(way_is_free, obstacles_of(model, state, 0, blocks), size)
            corners = model.bounds.reshape(2, 2).tolist()
            points = sampled_way(method, corners, *ends, is_free, Sampling(iterations, seed))
        else:
            names = ", ".join(("shortest", "astar", "jps", *SAMPLERS))
            raise ValueError(f"unknown method {method!r}: one of {names} finds a path")
        return points if len(points) else None

    def _own_radius(self) -> float:
        numbers = robots(self._session.simulation)
        first = int(numbers[0]) if len(numbers) else self._session.roster.index(self._population.robot.name)
        return float(self._session.simulation.model.reach[0, first])

    def get_map(self, resolution: float | None = None, *, bodies: bool = False) -> GridMap:
        """Return the world for planners: its extent, its obstacles, and the cells of its obstacle map, if it has one.

        Args:
            resolution: Side of a cell [m] (default: 0.1 m). The cells of a finer obstacle map are taken together: a
                cell is occupied if one of them is. Those of a coarser one stay as they are, with a warning.
            bodies: Return a grid in any case, in which cells are occupied that something touches which never moves. The
                cells then have this resolution, by default that of the obstacle map. If the size of the world is no
                multiple of it, they are slightly larger or smaller.

        Raises:
            ValueError: The resolution is not positive, or there would be more than ten million cells.
        """
        model, scenario = self._session.simulation.model, self._session.simulation.scenario
        size = scenario.world.width, scenario.world.height
        shape = n_cells(*size, DEFAULT_CELL if resolution is None else resolution)
        squares = None if scenario.occupied is None else model.map_squares[0, 0]
        grid: Floats | None = None
        if bodies:
            shape = squares.shape if squares is not None and resolution is None else shape
            state, blocks = self._session.simulation.state, fixed_bodies(model, 0)
            grid = np.where(touched_cells(model, state, 0, shape, blocks=blocks), 100.0, 0.0)
        elif squares is not None:
            grid = np.where(squares == 0, 100.0, 0.0)
            sides = [length / count for length, count in zip(size, grid.shape, strict=True)]
            if resolution is not None and resolution < FINER * min(sides):
                told = f"resolution {resolution:g} m is finer than the obstacle map: its cells stay as they are"
                warn_caller(f"{told}, {sides[0]:g} x {sides[1]:g} m", NoEffectWarning)
            elif (DEFAULT_CELL if resolution is None else resolution) > COARSER * max(sides):
                grid = coarser(grid, shape)
        return GridMap(
            width=size[0],
            height=size[1],
            resolution=DEFAULT_CELL if resolution is None else float(resolution),
            obstacle_list=self._population.obstacles,
            grid=grid,
            world_offset=scenario.world.offset,
        )


def point(values: ArrayLike, name: str) -> tuple[float, float]:
    """Return x and y [m] of a point, a pose or a state, flat or a column.

    Raises:
        ValueError: It is none.
    """
    numbers = row_of(values)[:2]
    if len(numbers) < 2 or not np.isfinite(numbers).all():
        raise ValueError(f"{name} must be x and y [m], got {values!r}")
    return float(numbers[0]), float(numbers[1])
