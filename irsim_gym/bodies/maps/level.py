"""Common parts of maps that are drawn for each level: their size, and memory for drawing."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from irsim_gym.base.errors import OptionError
from irsim_gym.base.options import kind, option, unordered_ranges
from irsim_gym.simulator.world.names import Flags, Floats, Group, Ints, Model, Outline, Shard, State, Struct, kernel

MOST_CELLS = 4_000_000
"""Maximum number of cells of a map that all worlds share."""
MOST_LEVEL_CELLS = 65_536
"""Maximum number of cells of a map that differs between worlds."""
LEAST_ORDER = 512
"""Minimum length of ``MapTables.order``, in which ``rooms`` keeps its table."""


@dataclass(repr=False)
class MapTables(Struct):
    """Memory for drawing a map; the first axis is the slot.

    Attributes:
        occupied: Occupied cells, shape ``(n_slots, columns, rows)``.
        before: Scratch, a flag for each cell, in the same way.
        line: Scratch for ``lay_cells``, shape ``(n_slots, columns)``.
        order: Scratch, a number for each cell and at least ``LEAST_ORDER``, shape ``(n_slots, n)``.
    """

    occupied: Flags
    before: Flags
    line: Floats
    order: Ints


def map_tables(model: Model, n_slots: int) -> MapTables:
    """Return memory for maps of the model's size."""
    columns, rows = model.map_room.shape[1:]
    occupied, before = (np.zeros((n_slots, columns, rows), np.bool_) for _ in range(2))
    order = np.zeros((n_slots, max(columns * rows, LEAST_ORDER)), np.int64)
    return MapTables(occupied=occupied, before=before, line=np.zeros((n_slots, columns)), order=order)


@kind
class CellsKind:
    """The base class of maps of cells."""

    disc_radius: float | None = option(
        None, gt=0.0, unit="m", meaning="Occupied cells hold discs of this radius; default: they are all occupied."
    )

    def outline(self) -> Outline:
        """Return an outline without rows: cells are no outline."""
        return Outline(solid=False)


@kind
class LevelMap(CellsKind):
    """The base class of maps that are drawn for each level."""

    is_random: ClassVar[bool] = True
    draw_maps: ClassVar[Callable[..., None]]
    """The kernel that draws the maps of some worlds."""

    resolution: float = option(1.0, gt=0.0, unit="m", meaning="Cell size: whole cells fill the world; 65536 at most.")
    border: bool = option(True, meaning="Occupy the outermost cells in every level.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Allocate memory for drawing."""
        group.tables = map_tables(model, n_slots)

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Draw the map of each world."""
        cells: Any = model.cells
        group.options[0].draw_maps(shard.worlds, shard.slot, group.params, group.tables, cells, state)


def map_size(resolution: float, width: float, height: float, most: int = MOST_LEVEL_CELLS) -> tuple[int, int]:
    """Return the numbers of columns and rows of a map over a world.

    Args:
        resolution: Side of a cell [m], rounded so that whole cells fill the world.
        width: Width of the world [m].
        height: Height of the world [m].
        most: Maximum number of cells.

    Raises:
        OptionError: If there would be too many cells.
    """
    columns, rows = (max(1, round(side / resolution)) for side in (width, height))
    if columns * rows > most:
        raise OptionError("resolution", f"makes {columns} x {rows} cells, at most {most}")
    return columns, rows


def bordered(options: LevelMap, width: float, height: float) -> Flags:
    """Return the cells that are occupied in all levels: the border, if any, shape ``(columns, rows)``.

    Raises:
        OptionError: If there would be too many cells, or none within the border.
    """
    columns, rows = map_size(options.resolution, width, height)
    if options.border and min(columns, rows) < 3:
        raise OptionError("resolution", f"makes {columns} x {rows} cells, of which the border leaves none free")
    occupied = np.full((columns, rows), options.border, np.bool_)
    if options.border:
        occupied[1:-1, 1:-1] = False
    return occupied


def span(length: float, resolution: float) -> int:
    """Return the number of cells along a length [m], at least one."""
    return max(1, round(length / resolution))


def share_problems(options: LevelMap, name: str) -> Iterator[tuple[str, str]]:
    """Yield a problem if an option is not a pair of bounds between 0 and 1."""
    yield from unordered_ranges(options, name, least=0.0)
    if getattr(options, name)[1] > 1.0:
        yield name, f"must lie between 0 and 1, got up to {getattr(options, name)[1]:g}"


@kernel
def clear_inside(occupied: Flags, edge: int) -> None:
    """Free all cells of a map, but occupy so many rings of them along its edge."""
    columns, rows = occupied.shape
    occupied[:] = edge > 0
    occupied[edge : columns - edge, edge : rows - edge] = False
