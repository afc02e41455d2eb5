"""Queries about one world for code that is not compiled: evaluation, checks, drawings."""

from collections.abc import Sequence

import numpy as np

from irsim_gym.simulator.cell_paths.occupancy import mark_touched
from irsim_gym.simulator.paths.clearance import Obstacles, way_is_free
from irsim_gym.simulator.paths.geodesic import shortest_path
from irsim_gym.simulator.paths.grid import Grid
from irsim_gym.simulator.paths.pulling import path_length
from irsim_gym.simulator.paths.reachability import is_reachable
from irsim_gym.simulator.world.names import Flags, Floats, Model, State

FINE, COARSE = 0.05, 0.1
"""Cell sizes for paths, and for tests whether there is one [m]."""

Point = Sequence[float] | Floats


def standing_bodies(model: Model, world: int) -> Flags:
    """Return flags of standing obstacles: present, standing and not unobstructed bodies, shape ``(body,)``."""
    return np.asarray(model.present[world] & model.stands & ~model.unobstructed)


def fixed_bodies(model: Model, world: int) -> Flags:
    """Return flags of bodies that are present, cannot move and are not unobstructed, shape ``(body,)``."""
    return np.asarray(model.present[world] & ~model.movable & ~model.unobstructed)


def free_path(
    model: Model,
    state: State,
    world: int,
    radius: float,
    start: Point,
    goal: Point,
    *,
    blocks: Flags | None = None,
    cell: float = FINE,
) -> Floats:
    """Return a short collision-free path, shape ``(n_points, 2)`` [m]; no points if there is none.

    Args:
        model: Constants of the episode.
        state: Present state, whose outlines are the obstacles.
        world: Index of the world.
        radius: Radius of the moving body [m].
        start: x and y [m]; further numbers are ignored.
        goal: x and y [m]; further numbers are ignored.
        blocks: Flags of bodies that are obstacles, shape ``(body,)``; by default ``standing_bodies``.
        cell: Cell size of the search [m].
    """
    grid, obstacles = Grid.over(model.bounds, cell), obstacles_of(model, state, world, blocks)
    path = grid.path()
    count = shortest_path(obstacles, float(radius), _point(start), _point(goal), grid, grid.search(), path)
    return path[:count].copy()


def free_path_length(
    model: Model,
    state: State,
    world: int,
    radius: float,
    start: Point,
    goal: Point,
    *,
    blocks: Flags | None = None,
    cell: float = FINE,
) -> float:
    """Return the length [m] of ``free_path``, inf if there is none; the arguments are the same."""
    path = free_path(model, state, world, radius, start, goal, blocks=blocks, cell=cell)
    return float(path_length(path, len(path))) if len(path) else float("inf")


def has_free_path(
    model: Model,
    state: State,
    world: int,
    radius: float,
    start: Point,
    goal: Point,
    *,
    blocks: Flags | None = None,
    cell: float = COARSE,
) -> bool:
    """Return whether ``is_reachable`` finds a path; the arguments are those of ``free_path``."""
    grid, obstacles = Grid.over(model.bounds, cell), obstacles_of(model, state, world, blocks)
    ends = _point(start), _point(goal)
    return bool(is_reachable(obstacles, float(radius), *ends, grid, grid.blocked(), grid.runs()))


def blocking_bodies(
    model: Model, state: State, world: int, radius: float, place: Point, blocks: Flags
) -> list[int | None]:
    """Return the bodies that a disc touches, None for the obstacle map. Arguments are those of ``free_path``."""
    touched: list[int | None] = []
    # None, the last, is the map alone; bodies are tested without the map.
    for b in (*np.flatnonzero(blocks).tolist(), None):
        alone = np.zeros_like(blocks)
        alone[[] if b is None else b] = True
        obstacles = obstacles_of(model, state, world, alone)
        if b is not None:
            obstacles = obstacles._replace(cells=None)
        if not way_is_free(obstacles, float(radius), _point(place), _point(place)):
            touched.append(b)
    return touched


def touched_cells(
    model: Model, state: State, world: int, n_cells: tuple[int, int], *, blocks: Flags | None = None
) -> Flags:
    """Return flags of the cells that a body or an occupied cell of the map touches, shape ``(columns, rows)``.

    Args:
        model: Constants of the episode.
        state: Current state of the worlds.
        world: Which world.
        n_cells: Number of columns and rows over the world; columns from the left, rows from the bottom.
        blocks: As for ``free_path``.
    """
    x_min, y_min, x_max, y_max = (float(value) for value in model.bounds)
    touched = np.zeros(n_cells, np.bool_)
    size = (x_max - x_min) / n_cells[0], (y_max - y_min) / n_cells[1]
    mark_touched(obstacles_of(model, state, world, blocks), x_min, y_min, *size, touched)
    return touched


def _point(values: Point) -> tuple[float, float]:
    return float(values[0]), float(values[1])


def obstacles_of(model: Model, state: State, world: int, blocks: Flags | None) -> Obstacles:
    """Return what is in the way; the arguments are those of ``free_path``."""
    chosen = standing_bodies(model, world) if blocks is None else np.ascontiguousarray(blocks, np.bool_)
    return Obstacles(model, state, int(world), chosen, model.cells, None)
