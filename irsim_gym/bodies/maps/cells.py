"""cells: randomly occupied cells, with a new number in each level, as in JaxNav (Rutherford et al. 2024)."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from irsim_gym.bodies.maps.level import LevelMap, MapTables, bordered, clear_inside, share_problems
from irsim_gym.simulator.cell_maps.world_maps import lay_cells
from irsim_gym.simulator.world.names import CellMaps, Flags, Ints, State, integer, kernel, kind, option


@kernel
def draw_cells(worlds: Ints, slot: int, options: Any, tables: MapTables, cells: CellMaps, state: State) -> None:
    """Occupy as many inner cells as are drawn, each choice of them as likely as any other.

    Reads: tables (line, occupied, order), state (random).
    Writes: tables (line, occupied, order), cells, state (random).
    """
    occupied, order = tables.occupied[slot], tables.order[slot]
    columns, rows = occupied.shape
    edge, fill = options[0].border, options[0]["fill"]
    # Inner cells are numbered column by column. `border` is a flag, here the thickness of the border: 0 or 1.
    up = rows - 2 * edge
    n_inner = (columns - 2 * edge) * up
    fewest, most = int(np.floor(fill[0] * n_inner)), int(np.floor(fill[1] * n_inner))
    for w in worlds:
        clear_inside(occupied, edge)
        count = integer(state.random, w, fewest, most + 1)
        for k in range(n_inner):
            order[k] = k
        # A Fisher-Yates shuffle of the first `count` places; what is drawn is used at once, so only the rest is kept.
        for k in range(count):
            chosen = integer(state.random, w, k, n_inner)
            cell = order[chosen]
            order[chosen] = order[k]
            occupied[edge + cell // up, edge + cell % up] = True
        lay_cells(cells, w, occupied, tables.line[slot])


@kind
class RandomCells(LevelMap):
    """Randomly occupied cells in each level: first their number is drawn uniformly, then their places."""

    draw_maps = staticmethod(draw_cells)

    fill: tuple[float, float] = option((0.0, 0.6), meaning="Bounds of the share of occupied cells without the border.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from share_problems(self, "fill")

    def occupied(self, width: float, height: float, name: str, find: Callable[[str], Path]) -> Flags:
        """Return the border, shape ``(columns, rows)``."""
        return bordered(self, width, height)
