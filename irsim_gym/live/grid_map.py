"""A world as cells, under the names that IR-SIM's planners read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from irsim_gym.arraytypes import Flags, Floats
from irsim_gym.world.irsim_readings import IrSimReadings

MOST_GRID_CELLS = 10_000_000
OCCUPIED = 50.0


@dataclass(frozen=True, eq=False)
class GridMap:
    """The cells of a world.

    Attributes:
        width: Size of the world along x [m].
        height: Size of the world along y [m].
        resolution: Requested side of a cell [m].
        grid: Occupancy of the cells from 0 to 100, more than 50 for an occupied one, shape ``(columns, rows)``: columns
            from the left, rows from the bottom. May be written into.
        world_offset: x, y of the lower left corner [m].
        obstacle_list: The obstacles of the world. Moving ones are listed here, but not in ``grid``.
    """

    width: float
    height: float
    resolution: float
    grid: Floats
    world_offset: tuple[float, float] = (0.0, 0.0)
    obstacle_list: Sequence[IrSimReadings] = field(default_factory=list)

    @property
    def grid_resolution(self) -> tuple[float, float]:
        """Width and height of a cell [m]."""
        return self.width / self.grid.shape[0], self.height / self.grid.shape[1]

    @property
    def cell_size(self) -> tuple[float, float]:
        """Width and height of a cell [m]."""
        return self.grid_resolution

    @property
    def origin(self) -> tuple[float, float]:
        """x, y of the lower left corner [m]."""
        return self.world_offset

    @property
    def occupied(self) -> Flags:
        """Whether each cell is occupied, shape ``(columns, rows)``."""
        return np.asarray(self.grid > OCCUPIED)

    def cell_of(self, x: float, y: float) -> tuple[int, int] | None:
        """Return column and row of the cell that holds the point ``x``, ``y`` [m]; None outside the world."""
        column = math.floor((x - self.world_offset[0]) / self.grid_resolution[0])
        row = math.floor((y - self.world_offset[1]) / self.grid_resolution[1])
        return (column, row) if 0 <= column < self.grid.shape[0] and 0 <= row < self.grid.shape[1] else None

    def center_of(self, column: int, row: int) -> tuple[float, float]:
        """Return x, y [m] of the centre of the cell in ``column`` and ``row``."""
        wide, high = self.grid_resolution
        return self.world_offset[0] + (column + 0.5) * wide, self.world_offset[1] + (row + 0.5) * high

    def grid_occupied(
        self, x: float, y: float, margin_x: float = 0.0, margin_y: float = 0.0, threshold: float = OCCUPIED
    ) -> bool:
        """Return whether the cell at a point, or one nearby, is occupied. Points outside the world are.

        Args:
            x: x of the point [m].
            y: y of the point [m].
            margin_x: Distance to search to the left and right [m], rounded up to whole cells.
            margin_y: Distance to search up and down [m], rounded up to whole cells.
            threshold: Occupancy above which a cell is occupied, without unit, from 0 to 100.
        """
        cell = self.cell_of(x, y)
        if cell is None:
            return True
        wide, high = self.grid_resolution
        aside, up = math.ceil(max(margin_x, 0.0) / wide), math.ceil(max(margin_y, 0.0) / high)
        left, low = max(cell[0] - aside, 0), max(cell[1] - up, 0)
        return bool((self.grid[left : cell[0] + aside + 1, low : cell[1] + up + 1] > threshold).any())

    def is_collision(self, geometry: Any) -> bool:
        """Return whether a shapely geometry touches an occupied cell, or one of ``obstacle_list`` but a map."""
        import shapely

        (wide, high), (left, bottom) = self.grid_resolution, self.world_offset
        columns, rows = np.nonzero(self.occupied)
        x, y = left + columns * wide, bottom + rows * high
        bodies = [body.geometry for body in self.obstacle_list if body.shape != "map"]
        return bool(shapely.intersects([*shapely.box(x, y, x + wide, y + high), *bodies], geometry).any())


def n_cells(width: float, height: float, resolution: float) -> tuple[int, int]:
    """Return the number of columns and rows of cells with some side [m] over a world.

    Raises:
        ValueError: The side is not positive, or there would be too many.
    """
    if not 0.0 < resolution < math.inf:
        raise ValueError(f"resolution must be > 0 [m], got {resolution!r}")
    if width / resolution * (height / resolution) > MOST_GRID_CELLS:
        raise ValueError(f"resolution is too small: {resolution:g} m gives more than {MOST_GRID_CELLS} cells")
    return max(1, round(width / resolution)), max(1, round(height / resolution))
