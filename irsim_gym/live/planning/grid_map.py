"""A world as planners read it, under IR-SIM's names."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.simulator.readings.irsim_readings import IrSimReadings

MOST_GRID_CELLS = 10_000_000
OCCUPIED = 50.0
FINER, COARSER = 0.95, 1.05
"""A resolution counts as another one than that of the grid below and above these shares of it, as in IR-SIM."""


@dataclass(eq=False)
class GridMap:
    """The extent of a world, its obstacles, and the cells of its obstacle map.

    Attributes:
        width: Size of the world along x [m].
        height: Size of the world along y [m].
        resolution: Requested side of a cell [m].
        obstacle_list: The obstacles of the world, which collide where they are at the moment of a query.
        grid: Occupancy of the cells from 0 to 100, more than 50 for an occupied one, shape ``(columns, rows)``: columns
            from the left, rows from the bottom. None without an obstacle map. May be written into.
        world_offset: x, y of the lower left corner [m].
    """

    width: float = 10.0
    height: float = 10.0
    resolution: float = 0.1
    obstacle_list: Sequence[IrSimReadings] | None = None
    grid: Floats | None = None
    world_offset: tuple[float, float] = (0.0, 0.0)
    _placed: tuple[Any, Any] = field(default=(None, None), init=False, repr=False)

    @property
    def grid_resolution(self) -> tuple[float, float] | None:
        """Width and height of a cell of the grid [m], None without a grid."""
        if self.grid is None:
            return None
        return self.width / self.grid.shape[0], self.height / self.grid.shape[1]

    @property
    def occupied(self) -> Flags | None:
        """Whether each cell of the grid is occupied, shape ``(columns, rows)``; None without a grid."""
        return None if self.grid is None else np.asarray(self.grid > OCCUPIED)

    def grid_occupied(
        self, x: float, y: float, margin_x: float = 0.0, margin_y: float = 0.0, threshold: float = OCCUPIED
    ) -> bool | None:
        """Return whether the cell at a point, or one nearby, is occupied; None without a grid.

        Points outside the world are occupied.

        Args:
            x: x of the point [m].
            y: y of the point [m].
            margin_x: Distance to search to the left and right [m], rounded up to whole cells.
            margin_y: Distance to search up and down [m], rounded up to whole cells.
            threshold: Occupancy above which a cell is occupied, without unit, from 0 to 100.
        """
        if self.grid is None or self.grid_resolution is None:
            return None
        aside, up = x - self.world_offset[0], y - self.world_offset[1]
        if not (0.0 <= aside < self.width and 0.0 <= up < self.height):
            return True
        ranges = []
        for place, margin, size in zip((aside, up), (margin_x, margin_y), self.grid_resolution, strict=True):
            cell, more = int(place / size), math.ceil(max(margin, 0.0) / size)
            ranges.append(slice(max(cell - more, 0), cell + more + 1))
        return bool((self.grid[tuple(ranges)] > threshold).any())

    def is_collision(self, geometry: Any) -> bool:
        """Return whether a shapely geometry leaves the world, or touches an occupied cell or an obstacle.

        Like IR-SIM, this takes a cell for the disc in it. For many geometries, ``collisions`` is faster.
        """
        return bool(self.collisions([geometry])[0])

    def collisions(self, geometries: Any) -> Flags:
        """Return ``is_collision`` of each of n shapely geometries, shape ``(n,)``."""
        import shapely

        shapes = np.asarray(geometries, object)
        bounds = shapely.bounds(shapes)
        low, high = np.array(self.world_offset), np.add(self.world_offset, (self.width, self.height))
        touched = np.asarray((bounds[:, :2] < low).any(axis=1) | (bounds[:, 2:] >= high).any(axis=1))
        if self.grid is not None:
            touched[self._on_cells(self.grid > OCCUPIED, shapes, bounds - np.tile(low, 2))] = True
        touched[self._obstacles().query(shapes, "intersects")[0]] = True
        return touched

    def _on_cells(self, occupied: Flags, shapes: Any, bounds: Floats) -> Any:
        """Return the geometries, by index, on occupied cells; their bounds are relative to the corner of the world."""
        import shapely

        cells, size = np.argwhere(occupied), np.array(self.grid_resolution)
        centers = shapely.points(self.world_offset + (cells + 0.5) * size)
        chosen, cell = shapely.STRtree(centers).query(shapes, "dwithin", distance=0.5 * size.max())
        # IR-SIM asks only the cells under the bounding box of the geometry.
        low, high = np.trunc(bounds[chosen, :2] / size), np.trunc(bounds[chosen, 2:] / size)
        return chosen[((low <= cells[cell]) & (cells[cell] <= high)).all(axis=1)]

    def _obstacles(self) -> Any:
        """Return a tree of the obstacles' geometries, made anew when one of them has moved."""
        import shapely

        bodies = self.obstacle_list or ()
        poses = [tuple(np.ravel(body.state)) for body in bodies]
        if self._placed[0] != poses:
            self._placed = poses, shapely.STRtree([body.geometry for body in bodies])
        return self._placed[1]


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


def coarser(grid: Floats, shape: tuple[int, int]) -> Floats:
    """Return a grid of fewer cells, each with the largest value of those of ``grid`` that begin in it."""
    for axis, count in enumerate(shape):
        starts = (np.arange(count) * grid.shape[axis] / count).astype(np.int64)
        grid = np.maximum.reduceat(grid, starts, axis=axis)
    return grid
