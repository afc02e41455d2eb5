"""What maps that are drawn for each level have in common: their size, and memory to draw them in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.errors import OptionError
from irsim_gym.structs import Struct
from irsim_gym.world.model import WorldModel

MOST_CELLS = 4_000_000
MOST_LEVEL_CELLS = 65_536
"""Most cells of a map that every world has for itself."""


@dataclass(repr=False)
class MapTables(Struct):
    """Memory in which a map is drawn; the first axis is the slot.

    Attributes:
        occupied: Occupied cells, shape ``(n_slots, columns, rows)``.
        line: Scratch for ``lay_cells``, shape ``(n_slots, columns)``.
        order: Scratch, a number for each cell, shape ``(n_slots, columns * rows)``.
    """

    occupied: Flags
    line: Floats
    order: Ints


def map_tables(model: WorldModel, n_slots: int) -> MapTables:
    """Return memory for maps of the model's size."""
    columns, rows = model.map_room.shape[1:]
    return MapTables(
        occupied=np.zeros((n_slots, columns, rows), np.bool_),
        line=np.zeros((n_slots, columns)),
        order=np.zeros((n_slots, columns * rows), np.int64),
    )


def map_size(resolution: float, width: float, height: float, most: int = MOST_LEVEL_CELLS) -> tuple[int, int]:
    """Return the numbers of columns and rows of a map over a world.

    Args:
        resolution: Side of a cell [m], rounded so that whole cells fill the world.
        width: Width of the world [m].
        height: Height of the world [m].
        most: Most cells that there may be.

    Raises:
        OptionError: There would be too many cells.
    """
    columns, rows = (max(1, round(side / resolution)) for side in (width, height))
    if columns * rows > most:
        raise OptionError("resolution", f"makes {columns} x {rows} cells, at most {most}")
    return columns, rows


def bordered(columns: int, rows: int, border: bool) -> Flags:
    """Return a map of which the outermost cells are occupied, or none, shape ``(columns, rows)``."""
    occupied = np.full((columns, rows), border, np.bool_)
    occupied[1:-1, 1:-1] = False
    return occupied
