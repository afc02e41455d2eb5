"""Random occupancy maps for the tests, and the same cells in shapely."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from irsim_gym.arraytypes import CellMap
from irsim_gym.geometry.cell_room import find_room
from irsim_gym.geometry.cells import find_boxes, find_free_squares


def cell_map(occupied: Any, x: float = 0.0, y: float = 0.0, width: float = 1.0, height: float = 1.0) -> CellMap:
    occupied = np.asarray(occupied, np.bool_)
    squares = np.zeros((4, *occupied.shape), np.uint8)
    find_free_squares(occupied, squares)
    room = np.zeros(occupied.shape, np.float32)
    found = CellMap(x, y, width, height, 0, squares, find_boxes(occupied), room)
    find_room(found, np.zeros(len(occupied)))
    return found


def random_map(seed: int, share: float = 0.2, columns: int = 17, rows: int = 12) -> tuple[Any, Any]:
    """Return a map of oblong cells with lower left corner (1, 2), and its occupied area."""
    occupied: NDArray[np.bool_] = np.random.default_rng(seed).random((columns, rows)) < share
    return cell_map(occupied, 1.0, 2.0, 0.3, 0.2), area(occupied, 1.0, 2.0, 0.3, 0.2)


def area(occupied: Any, x: float, y: float, width: float, height: float) -> Any:
    boxes = [
        shapely.box(x + i * width, y + j * height, x + (i + 1) * width, y + (j + 1) * height)
        for i, j in np.argwhere(occupied)
    ]
    return shapely.union_all(boxes)
