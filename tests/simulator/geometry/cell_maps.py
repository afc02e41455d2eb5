"""Random occupancy maps for the tests, and the same cells in shapely."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import CellMap, CellMaps
from irsim_gym.simulator.cell_maps.world_maps import lay_cells, most_boxes


def cell_maps(
    occupied: Any, x: float = 0.0, y: float = 0.0, width: float = 1.0, height: float = 1.0, radius: float = 0.0
) -> CellMaps:
    """Return the maps of some worlds, ``(n_worlds, columns, rows)``."""
    occupied = np.asarray(occupied, np.bool_)
    n, columns, rows = occupied.shape
    boxes = np.full((n, most_boxes(columns, rows), 4), -1, np.int32)
    arrays = np.zeros((n, 4, columns, rows), np.uint8), boxes, np.zeros(n, np.int64)
    maps = CellMaps(x, y, width, height, 0, *arrays, np.zeros((n, columns, rows), np.float32), radius)
    for w in range(n):
        lay_cells(maps, w, occupied[w], np.zeros(columns))
    return maps


def cell_map(
    occupied: Any, x: float = 0.0, y: float = 0.0, width: float = 1.0, height: float = 1.0, radius: float = 0.0
) -> CellMap:
    maps = cell_maps([occupied], x, y, width, height, radius)
    return CellMap(x, y, width, height, 0, maps.squares[0], maps.boxes[0], int(maps.n_boxes[0]), maps.room[0], radius)


def random_map(seed: int, share: float = 0.2, columns: int = 17, rows: int = 12) -> tuple[Any, Any]:
    """Return a map of oblong cells with lower left corner (1, 2), and its occupied area."""
    occupied: NDArray[np.bool_] = np.random.default_rng(seed).random((columns, rows)) < share
    return cell_map(occupied, 1.0, 2.0, 0.3, 0.2), area(occupied, 1.0, 2.0, 0.3, 0.2)


def area(occupied: Any, x: float, y: float, width: float, height: float, radius: float = 0.0) -> Any:
    if radius > 0.0:
        centres = [(x + (i + 0.5) * width, y + (j + 0.5) * height) for i, j in np.argwhere(occupied)]
        return shapely.union_all([shapely.Point(one).buffer(radius, quad_segs=256) for one in centres])
    boxes = [
        shapely.box(x + i * width, y + j * height, x + (i + 1) * width, y + (j + 1) * height)
        for i, j in np.argwhere(occupied)
    ]
    return shapely.union_all(boxes)
