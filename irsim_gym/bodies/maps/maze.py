"""maze: corridors between walls, drawn for each level: a spanning tree, with loops where further walls are opened."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from irsim_gym.base.errors import OptionError
from irsim_gym.bodies.maps.level import LevelMap, MapTables, bordered, span
from irsim_gym.simulator.cell_maps.world_maps import lay_cells
from irsim_gym.simulator.world.names import CellMaps, Flags, Ints, State, integer, kernel, kind, option, uniform


@kernel
def draw_maze(worlds: Ints, slot: int, options: Any, tables: MapTables, cells: CellMaps, state: State) -> None:
    """Walk from crossing to crossing that are new, back where there are none, and open the walls on the way.

    Then open each other wall between neighbouring crossings with the given probability.

    Reads: tables (before, line, occupied, order), state (random).
    Writes: tables (before, line, occupied, order), cells, state (random).
    """
    occupied, opened, path = tables.occupied[slot], tables.before[slot], tables.order[slot]
    edge, loops = options[0].border, options[0].loops
    wide = max(1, int(np.rint(options[0].corridor / options[0].resolution)))
    # As in MazeMap.occupied.
    n_across, n_up = (occupied.shape[0] + 1 - 2 * edge) // (wide + 1), (occupied.shape[1] + 1 - 2 * edge) // (wide + 1)
    for w in worlds:
        occupied[:] = True
        opened[:] = False
        # `count` is the height of the stack in `path`: the crossings that lead to this one.
        cell, count = integer(state.random, w, 0, n_across * n_up), 0
        open_cells(occupied, edge, wide, cell // n_up, cell % n_up, 0, 0)
        while True:
            i, j = cell // n_up, cell % n_up
            opened[i, j] = True
            n_ways = 0
            for side in range(4):
                to_i, to_j = i + (side == 0) - (side == 1), j + (side == 2) - (side == 3)
                is_new = 0 <= to_i < n_across and 0 <= to_j < n_up and not opened[to_i, to_j]
                n_ways += int(is_new)
            # A dead end: back to the crossing before, or done.
            if n_ways == 0:
                if count == 0:
                    break
                count -= 1
                cell = int(path[count])
                continue
            # One of the new neighbours: the loop below counts down to it.
            chosen = integer(state.random, w, 0, n_ways)
            for side in range(4):
                to_i, to_j = i + (side == 0) - (side == 1), j + (side == 2) - (side == 3)
                if not (0 <= to_i < n_across and 0 <= to_j < n_up) or opened[to_i, to_j]:
                    continue
                if chosen == 0:
                    path[count] = cell
                    count += 1
                    open_cells(occupied, edge, wide, i, j, to_i - i, to_j - j)
                    cell = to_i * n_up + to_j
                    break
                chosen -= 1
        # Each wall once, to the right and upwards. Walls that are open already stay open, but take their draw.
        for i in range(n_across):
            for j in range(n_up):
                for side in range(2):
                    to_i, to_j = i + (side == 0), j + (side == 1)
                    if to_i < n_across and to_j < n_up and uniform(state.random, w, 0.0, 1.0) < loops:
                        open_cells(occupied, edge, wide, i, j, to_i - i, to_j - j)
        lay_cells(cells, w, occupied, tables.line[slot])


@kernel
def open_cells(occupied: Flags, edge: int, wide: int, i: int, j: int, step_i: int, step_j: int) -> None:
    """Free the cells of a crossing, of the one a step away, and of the wall between them.

    Args:
        occupied: The cells, changed.
        edge: Thickness of the border.
        wide: Width of a corridor.
        i: Column of the crossing.
        j: Row of the crossing.
        step_i: Columns to the other.
        step_j: Rows to the other.
    """
    # From the lower left of the nearer crossing to the upper right of the other one.
    pitch = wide + 1
    first_i, first_j = edge + min(i, i + step_i) * pitch, edge + min(j, j + step_j) * pitch
    end_i, end_j = edge + max(i, i + step_i) * pitch + wide, edge + max(j, j + step_j) * pitch + wide
    occupied[first_i:end_i, first_j:end_j] = False


@kind
class MazeMap(LevelMap):
    """Corridors between walls that are one cell thick; every corridor can be reached from every other."""

    draw_maps = staticmethod(draw_maze)

    corridor: float = option(1.0, gt=0.0, unit="m", meaning="Width of the corridors, in whole cells.")
    loops: float = option(0.1, ge=0.0, le=1.0, meaning="Probability that a needless wall is opened: 0 leaves one way.")

    def occupied(self, width: float, height: float, name: str, find: Callable[[str], Path]) -> Flags:
        """Return the border, shape ``(columns, rows)``.

        Raises:
            OptionError: If there is room for only one crossing.
        """
        occupied = bordered(self, width, height)
        wide, walls = span(self.corridor, self.resolution), 1 if self.border else -1
        # n corridors and the n - 1 walls between them take n (wide + 1) - 1 cells, and a border two more.
        crossings = [(cells - walls) // (wide + 1) for cells in occupied.shape]
        if min(crossings) < 1 or max(crossings) < 2:
            raise OptionError("corridor", f"leaves room for {crossings[0]} x {crossings[1]} crossings, at least 2 x 1")
        return occupied
