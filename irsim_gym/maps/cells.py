"""cells: occupied cells anywhere, another number of them in each level, as in JaxNav (Rutherford et al. 2024)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from irsim_gym.arraytypes import CellMaps, Flags, Ints
from irsim_gym.errors import OptionError
from irsim_gym.geometry.world_maps import lay_cells
from irsim_gym.jit import kernel
from irsim_gym.maps.level import MapTables, bordered, map_size, map_tables
from irsim_gym.rng import integer
from irsim_gym.scenario.options import kind, option, unordered_ranges
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.outline import Outline
from irsim_gym.world.state import WorldState


@kind
class RandomCells:
    """Occupied cells at random in each level: their number is drawn first, evenly, then which they are."""

    is_random: ClassVar[bool] = True
    only_kernels: ClassVar[bool] = True

    resolution: float = option(
        1.0, gt=0.0, unit="m", meaning="Cell size, rounded so that whole cells fill the world; at most 65536 cells."
    )
    fill: tuple[float, float] = option(
        (0.0, 0.6), meaning="Bounds of the share of occupied cells, those of the border not counted, 0 to 1."
    )
    border: bool = option(True, meaning="Occupy the outermost cells in every level.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        yield from unordered_ranges(self, "fill", least=0.0)
        if self.fill[1] > 1.0:
            yield "fill", f"must lie between 0 and 1, got up to {self.fill[1]:g}"

    def outline(self) -> Outline:
        """Return an outline without rows: cells are no outline."""
        return Outline(solid=False)

    def occupied(self, width: float, height: float, name: str, find: Callable[[str], Path]) -> Flags:
        """Return the border, shape ``(columns, rows)``.

        Raises:
            OptionError: There would be too many cells, or none within the border.
        """
        columns, rows = map_size(self.resolution, width, height)
        if self.border and min(columns, rows) < 3:
            raise OptionError("resolution", f"makes {columns} x {rows} cells, of which the border leaves none free")
        return bordered(columns, rows, self.border)

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> None:
        """Make room to draw in."""
        group.tables = map_tables(model, n_slots)

    @staticmethod
    def draw(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Draw the cells of each world."""
        cells: Any = model.cells
        draw_cells(shard.worlds, shard.slot, group.params, group.tables, cells, state)


@kernel
def draw_cells(worlds: Ints, slot: int, options: Any, tables: MapTables, cells: CellMaps, state: WorldState) -> None:
    """Occupy as many inner cells as are drawn, each choice of them as likely as any other.

    Reads: tables (line, occupied, order), state (random).
    Writes: tables (line, occupied, order), cells, state (random).
    """
    occupied, order = tables.occupied[slot], tables.order[slot]
    columns, rows = occupied.shape
    edge, fill = options[0].border, options[0].fill
    across, up = columns - 2 * edge, rows - 2 * edge
    n_inner = across * up
    fewest, most = int(np.floor(fill[0] * n_inner)), int(np.floor(fill[1] * n_inner))
    for w in worlds:
        occupied[:] = edge > 0
        occupied[edge : columns - edge, edge : rows - edge] = False
        count = integer(state.random, w, fewest, most + 1)
        for k in range(n_inner):
            order[k] = k
        for k in range(count):
            chosen = integer(state.random, w, k, n_inner)
            cell = order[chosen]
            order[chosen] = order[k]
            occupied[edge + cell // up, edge + cell % up] = True
        lay_cells(cells, w, occupied, tables.line[slot])
