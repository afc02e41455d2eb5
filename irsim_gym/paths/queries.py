"""Questions about one world, for code that is not compiled: evaluation, checks, drawings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from irsim_gym.arraytypes import Bytes, Flags, Floats
from irsim_gym.paths.clearance import Outlines
from irsim_gym.paths.geodesic import shortest_path
from irsim_gym.paths.grid import Grid
from irsim_gym.paths.occupancy import mark_touched
from irsim_gym.paths.pulling import path_length
from irsim_gym.paths.reachability import is_reachable
from irsim_gym.paths.spread import PARENT, clear_field, offer, spread
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState

FINE, COARSE = 0.05, 0.1

Point = Sequence[float] | Floats


def standing_bodies(model: WorldModel, world: int) -> Flags:
    """Return which bodies are always in the way: present, standing and not unobstructed, shape ``(body,)``."""
    return np.asarray(model.present[world] & model.stands & ~model.unobstructed)


def fixed_bodies(model: WorldModel, world: int) -> Flags:
    """Return which bodies never move: present, without a way to move and not unobstructed, shape ``(body,)``."""
    return np.asarray(model.present[world] & ~model.movable & ~model.unobstructed)


def free_path(
    model: WorldModel,
    state: WorldState,
    world: int,
    radius: float,
    start: Point,
    goal: Point,
    *,
    blocks: Flags | None = None,
    cell: float = FINE,
) -> Floats:
    """Return a short path that is free of collisions, shape ``(n_points, 2)`` [m]; no points if there is none.

    Args:
        model: Constants of the episode.
        state: The moment, whose outlines are in the way.
        world: Which world.
        radius: Radius of the moving body [m].
        start: x and y [m]; more is ignored.
        goal: x and y [m]; more is ignored.
        blocks: Which bodies are in the way, shape ``(body,)``; as ``standing_bodies`` if not given.
        cell: Side of the cells [m] in which ways around things are sought.
    """
    grid, outlines = Grid.over(model.bounds, cell), _outlines(model, state, world, blocks)
    path = grid.path()
    ends = float(start[0]), float(start[1]), float(goal[0]), float(goal[1])
    place = grid.origin_x, grid.origin_y, grid.cell
    memory = grid.blocked(), grid.field(), grid.queue()
    count = shortest_path(*outlines, float(radius), *ends, *place, *memory, path)
    return path[:count].copy()


def free_path_length(
    model: WorldModel,
    state: WorldState,
    world: int,
    radius: float,
    start: Point,
    goal: Point,
    *,
    blocks: Flags | None = None,
    cell: float = FINE,
) -> float:
    """Return the length [m] of ``free_path``, inf if there is none; arguments as there."""
    path = free_path(model, state, world, radius, start, goal, blocks=blocks, cell=cell)
    return float(path_length(path, len(path))) if len(path) else float("inf")


def has_free_path(
    model: WorldModel,
    state: WorldState,
    world: int,
    radius: float,
    start: Point,
    goal: Point,
    *,
    blocks: Flags | None = None,
    cell: float = COARSE,
) -> bool:
    """Return whether ``is_reachable`` finds a way; arguments as for ``free_path``."""
    grid, outlines = Grid.over(model.bounds, cell), _outlines(model, state, world, blocks)
    ends = float(start[0]), float(start[1]), float(goal[0]), float(goal[1])
    place = grid.origin_x, grid.origin_y, grid.cell
    return bool(is_reachable(*outlines, float(radius), *ends, *place, grid.blocked(), grid.runs()))


def touched_cells(
    model: WorldModel, state: WorldState, world: int, n_cells: tuple[int, int], *, blocks: Flags | None = None
) -> Flags:
    """Return which cells a body or an occupied cell of the map touches, shape ``(columns, rows)``.

    Args:
        model: Constants of the episode.
        state: The moment.
        world: Which world.
        n_cells: Number of columns and rows over the world; columns from the left, rows from the bottom.
        blocks: As for ``free_path``.
    """
    x_min, y_min, x_max, y_max = (float(value) for value in model.bounds)
    touched = np.zeros(n_cells, np.bool_)
    size = (x_max - x_min) / n_cells[0], (y_max - y_min) / n_cells[1]
    mark_touched(*_outlines(model, state, world, blocks), x_min, y_min, *size, touched)
    return touched


def cells_way(blocked: Bytes, start: tuple[int, int], goal: tuple[int, int]) -> list[tuple[int, int]]:
    """Return row and column of the cells on a shortest way over free cells, start and goal included; none without one.

    A step leads to a cell beside or across, or a knight's move away, through free cells alone; it may pass between two
    blocked ones that meet at a corner.

    Args:
        blocked: 1 for a blocked cell, shape ``(rows, columns)``.
        start: Row and column.
        goal: Row and column.
    """
    rows, columns = blocked.shape
    inside = all(0 <= row < rows and 0 <= column < columns for row, column in (start, goal))
    if not inside or blocked[start] or blocked[goal]:
        return []
    field, queue = np.zeros((rows, columns)), np.zeros((3, rows * columns + 8), np.int64)
    clear_field(field, queue)
    offer(field.reshape(-1), queue, goal[0] * columns + goal[1], 0.0, -1, 1.0)
    spread(blocked, 1.0, *start, field, queue)
    if not np.isfinite(field[start]):
        return []
    way, here = [], start[0] * columns + start[1]
    while here >= 0:
        way.append((here // columns, here % columns))
        here = int(queue[PARENT, here])
    return way


def _outlines(model: WorldModel, state: WorldState, world: int, blocks: Flags | None) -> Outlines:
    """Return the tables of one world in the order that the kernels want."""
    return (
        state.segments[world],
        model.segment_start,
        model.segment_count[world % len(model.segment_count)],
        state.discs[world],
        model.disc_start,
        model.disc_count[world % len(model.disc_count)],
        model.solid,
        standing_bodies(model, world) if blocks is None else np.ascontiguousarray(blocks, np.bool_),
        model.cells,
    )
