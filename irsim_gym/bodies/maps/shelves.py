"""shelves: a warehouse, drawn for each level: rows of shelves, some of which are missing."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from irsim_gym.base.errors import OptionError
from irsim_gym.bodies.maps.level import LevelMap, MapTables, bordered, clear_inside, share_problems, span
from irsim_gym.simulator.cell_maps.world_maps import lay_cells
from irsim_gym.simulator.world.names import CellMaps, Flags, Ints, State, kernel, kind, option, uniform


@kernel
def draw_shelves(worlds: Ints, slot: int, options: Any, tables: MapTables, cells: CellMaps, state: State) -> None:
    """Put as many shelves as fit into the middle of each world, and leave out some.

    Reads: tables (line, occupied), state (random).
    Writes: tables (line, occupied), cells, state (random).
    """
    occupied, map_options = tables.occupied[slot], options[0]
    edge, cell = map_options.border, map_options.resolution
    length, depth = max(1, int(np.rint(map_options.shelf[0] / cell))), max(1, int(np.rint(map_options.shelf[1] / cell)))
    aisle = max(1, int(np.rint(map_options.aisle / cell)))
    for w in worlds:
        clear_inside(occupied, edge)
        # Drawn in any case, so that the option `turn` does not change the other random numbers.
        is_turned = uniform(state.random, w, 0.0, 1.0) < 0.5 and map_options.turn > 0
        missing = uniform(state.random, w, map_options.missing[0], map_options.missing[1])
        wide, high = (depth, length) if is_turned else (length, depth)
        # n shelves take n (side + aisle) cells and one more aisle.
        across, up = occupied.shape[0] - 2 * edge - aisle, occupied.shape[1] - 2 * edge - aisle
        n_across, n_up = across // (wide + aisle), up // (high + aisle)
        # What is left over is shared between both ends.
        first_i = edge + aisle + (across - n_across * (wide + aisle)) // 2
        first_j = edge + aisle + (up - n_up * (high + aisle)) // 2
        for a in range(n_across):
            for b in range(n_up):
                if uniform(state.random, w, 0.0, 1.0) >= missing:
                    i, j = first_i + a * (wide + aisle), first_j + b * (high + aisle)
                    occupied[i : i + wide, j : j + high] = True
        lay_cells(cells, w, occupied, tables.line[slot])


@kind
class ShelvesMap(LevelMap):
    """Shelves in rows and columns with aisles between them, along x or along y; some shelves are missing."""

    draw_maps = staticmethod(draw_shelves)

    shelf: tuple[float, float] = option((3.0, 1.0), unit="m", meaning="Length and depth of a shelf, in whole cells.")
    aisle: float = option(1.5, gt=0.0, unit="m", meaning="Width of the aisles, in whole cells.")
    missing: tuple[float, float] = option((0.0, 0.3), meaning="Bounds of the probability that a shelf is missing.")
    turn: bool = option(True, meaning="Shelves stand along x or along y, as each level draws; else along x.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from share_problems(self, "missing")
        if min(self.shelf) <= 0.0:
            yield "shelf", f"must be two lengths > 0, got [{self.shelf[0]:g}, {self.shelf[1]:g}]"

    def occupied(self, width: float, height: float, name: str, find: Callable[[str], Path]) -> Flags:
        """Return the border, shape ``(columns, rows)``.

        Raises:
            OptionError: If a shelf and the aisles around it do not fit.
        """
        occupied = bordered(self, width, height)
        needed = [span(side, self.resolution) + 2 * span(self.aisle, self.resolution) for side in self.shelf]
        room = [cells - 2 * self.border for cells in occupied.shape]
        ways = [needed, needed[::-1]] if self.turn else [needed]
        if any(extent > other for way in ways for extent, other in zip(way, room, strict=True)):
            raise OptionError("shelf", "does not fit into the world with an aisle on all sides")
        return occupied
