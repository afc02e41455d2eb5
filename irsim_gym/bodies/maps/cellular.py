"""cellular: random cells smoothed by a cellular automaton, drawn for each level: caves, or BARN's clutter."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from irsim_gym.base.options import kind, option, unordered_ranges
from irsim_gym.bodies.maps.level import LevelMap, MapTables, bordered, clear_inside, share_problems
from irsim_gym.simulator.cell_maps.world_maps import lay_cells
from irsim_gym.simulator.world.names import CellMaps, Flags, Ints, State, integer, kernel, uniform

MOST_ROUNDS = 100
"""Maximum number of rounds of smoothing."""


@kernel
def draw_cellular(worlds: Ints, slot: int, options: Any, tables: MapTables, cells: CellMaps, state: State) -> None:
    """Occupy cells at random, and smooth them.

    Reads: tables (before, line, occupied, order), state (random).
    Writes: tables (before, line, occupied, order), cells, state (random).
    """
    occupied, before, map_options = tables.occupied[slot], tables.before[slot], options[0]
    columns, rows = occupied.shape
    edge = map_options.border
    for w in worlds:
        clear_inside(occupied, edge)
        fill = uniform(state.random, w, map_options["fill"][0], map_options["fill"][1])
        for i in range(edge, columns - edge):
            for j in range(edge, rows - edge):
                occupied[i, j] = uniform(state.random, w, 0.0, 1.0) < fill
        for _ in range(integer(state.random, w, map_options.rounds[0], map_options.rounds[1] + 1)):
            smooth(occupied, before, tables.order[slot], edge, map_options.fill_from, map_options.clear_to)
        lay_cells(cells, w, occupied, tables.line[slot])


@kernel
def smooth(occupied: Flags, before: Flags, sums: Ints, edge: int, fill_from: int, clear_to: int) -> None:
    """Occupy or free each cell by how many of its eight neighbours are occupied; those outside of the map are free.

    Args:
        occupied: The cells, changed.
        before: Scratch, as large.
        sums: Scratch: occupied cells of three neighbouring columns in each row, shape ``(rows,)`` or longer.
        edge: So many rings of cells along the edge stay as they are.
        fill_from: So many occupied neighbours, or more, occupy a cell.
        clear_to: So many, or fewer, free it.
    """
    columns, rows = occupied.shape
    for i in range(columns):
        for j in range(rows):
            before[i, j] = occupied[i, j]
    for i in range(edge, columns - edge):
        for j in range(rows):
            sums[j] = int(before[i, j])
        for a in range(max(i - 1, 0), min(i + 2, columns)):
            if a != i:
                for j in range(rows):
                    sums[j] += int(before[a, j])
        # Sums of three columns in the rows below, at and above the cell: together its neighbours and itself.
        low, current = 0, sums[edge]
        if edge > 0:
            low = sums[edge - 1]
        for j in range(edge, rows - edge):
            high = sums[j + 1] if j + 1 < rows else 0
            count = low + current + high - int(before[i, j])
            # Between both bounds, a cell stays as it was.
            occupied[i, j] = count >= fill_from or (before[i, j] and count > clear_to)
            low, current = current, high


@kind
class CellularMap(LevelMap):
    """Randomly occupied cells, smoothed by a cellular automaton over the eight neighbours of each cell."""

    draw_maps = staticmethod(draw_cellular)

    fill: tuple[float, float] = option((0.4, 0.48), meaning="Bounds of the probability that a cell begins occupied.")
    rounds: tuple[int, int] = option((4, 4), meaning="Bounds of how often all cells are smoothed, at most 100.")
    fill_from: int = option(5, ge=1, le=9, meaning="A cell with at least this many occupied neighbours is occupied.")
    clear_to: int = option(3, ge=-1, le=8, meaning="Cells with so many occupied neighbours at most become free.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from share_problems(self, "fill")
        yield from unordered_ranges(self, "rounds", least=0.0)
        if self.rounds[1] > MOST_ROUNDS:
            yield "rounds", f"must be at most {MOST_ROUNDS}, got {self.rounds[1]}"
        if self.clear_to >= self.fill_from:
            yield "clear_to", f"must be less than fill_from, got {self.clear_to} and {self.fill_from}"

    def occupied(self, width: float, height: float, name: str, find: Callable[[str], Path]) -> Flags:
        """Return the border, shape ``(columns, rows)``."""
        return bordered(self, width, height)
