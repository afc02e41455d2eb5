"""The density of a level: the share of the world that standing obstacles cover."""

from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import CellMaps, Floats
from irsim_gym.simulator.cell_paths.queries import standing_bodies
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.outline import outline_rows
from irsim_gym.simulator.world.state import State

CORNERS = 32
"""Number of segments that approximate a quarter circle."""


def covered_share(model: Model, state: State, world: int) -> float:
    """Return the share of the world's rectangle that standing bodies and the map cover."""
    import shapely

    parts: list[Any] = []
    for body in np.flatnonzero(standing_bodies(model, world)).tolist():
        segments, discs = outline_rows(model, state, world, body)
        if model.solid[body]:
            parts += [shapely.Polygon(corners) for corners in _loops(segments)]
        parts += [shapely.Point(x, y).buffer(radius, quad_segs=CORNERS) for x, y, radius in discs]
    if (cells := model.cells) is not None:
        parts += [shapely.box(*box) for box in _map_boxes(cells, world)]
        parts += [shapely.Point(place).buffer(cells.radius, quad_segs=CORNERS) for place in _map_discs(cells, world)]
    bounds = shapely.box(*model.bounds.tolist())
    return float(shapely.union_all(parts).intersection(bounds).area / bounds.area)


def _loops(segments: Floats) -> list[Floats]:
    """Return the vertices of the closed chains of segments, each ``(n, 2)`` [m]."""
    if not len(segments):
        return []
    ends = np.flatnonzero((segments[:-1, 2:] != segments[1:, :2]).any(axis=1)) + 1
    return [chain[:, :2] for chain in np.split(segments, ends)]


def _map_discs(cells: CellMaps, world: int) -> Floats:
    """Return the centres of the discs in a map's occupied cells [m], shape ``(n, 2)``; empty if cells hold no discs."""
    if cells.radius == 0.0:
        return np.zeros((0, 2))
    places = np.argwhere(cells.squares[world % len(cells.n_boxes), 0] == 0)
    centres: Floats = np.array([cells.x, cells.y]) + (places + 0.5) * np.array([cells.width, cells.height])
    return centres


def _map_boxes(cells: CellMaps, world: int) -> Floats:
    """Return rectangles that cover a map's occupied cells: x_min, y_min, x_max, y_max [m], shape ``(n, 4)``.

    The result is empty if cells hold discs.
    """
    if cells.radius > 0.0:
        return np.zeros((0, 4))
    row = world % len(cells.n_boxes)
    first_column, end_column, first_row, end_row = cells.boxes[row, : cells.n_boxes[row]].T
    x = cells.x + cells.width * np.stack([first_column, end_column])
    y = cells.y + cells.height * np.stack([first_row, end_row])
    return np.stack([x[0], y[0], x[1], y[1]], axis=1)
