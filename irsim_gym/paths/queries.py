"""Questions about one world, for code that is not compiled: evaluation, checks, drawings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from irsim_gym.arraytypes import Flags, Floats
from irsim_gym.paths.clearance import Outlines
from irsim_gym.paths.geodesic import shortest_path
from irsim_gym.paths.grid import Grid
from irsim_gym.paths.pulling import path_length
from irsim_gym.paths.reachability import is_reachable
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState

FINE, COARSE = 0.05, 0.1

Point = Sequence[float] | Floats


def standing_bodies(model: WorldModel, world: int) -> Flags:
    """Return which bodies are always in the way: present, standing and not unobstructed, shape ``(body,)``."""
    return np.asarray(model.present[world] & model.stands & ~model.unobstructed)


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
