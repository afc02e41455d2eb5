"""rooms: a rectangle divided into rooms by walls with doors, drawn for each level."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from irsim_gym.base.errors import OptionError
from irsim_gym.base.options import kind, option, unordered_ranges
from irsim_gym.bodies.maps.level import LEAST_ORDER, LevelMap, MapTables, bordered, clear_inside, span
from irsim_gym.simulator.cell_maps.world_maps import lay_cells
from irsim_gym.simulator.world.names import CellMaps, Flags, Ints, State, integer, kernel, uniform

LEFT, RIGHT, LOW, HIGH, WHOLE = 0, 1, 2, 3, 4
"""Columns of a table of rooms: first and end column, first and end row, and whether the room cannot be divided."""
MOST_ROOMS = LEAST_ORDER // 5
"""Maximum number of rooms: as many rows of five numbers as the scratch memory holds at least."""
TRIES = 20
"""Maximum number of attempts to divide a level into the drawn number of rooms."""


@kernel
def draw_rooms(worlds: Ints, slot: int, options: Any, tables: MapTables, cells: CellMaps, state: State) -> None:
    """Divide each world into rooms: a room is the likelier to be divided, the larger it is.

    Reads: tables (line, occupied, order), state (random).
    Writes: tables (line, occupied), cells, state (random).
    """
    occupied, map_options = tables.occupied[slot], options[0]
    # Scratch that other maps use for cells.
    rooms = tables.order[slot][: 5 * MOST_ROOMS].reshape(MOST_ROOMS, 5)
    edge = map_options.border
    for w in worlds:
        n_rooms = integer(state.random, w, map_options.number[0], map_options.number[1] + 1)
        for _ in range(TRIES):
            clear_inside(occupied, edge)
            rooms[0, LEFT], rooms[0, RIGHT] = edge, occupied.shape[0] - edge
            rooms[0, LOW], rooms[0, HIGH], rooms[0, WHOLE] = edge, occupied.shape[1] - edge, 0
            n = 1
            while n < n_rooms:
                chosen = choose_room(rooms, n, w, state)
                if chosen < 0:
                    break
                axis = 0 if uniform(state.random, w, 0.0, 1.0) < share_across(rooms[chosen]) else 1
                if divide(occupied, rooms, chosen, n, axis, map_options, w, state) or divide(
                    occupied, rooms, chosen, n, 1 - axis, map_options, w, state
                ):
                    n += 1
                else:
                    rooms[chosen, WHOLE] = 1
            # Else rooms were too small to be divided further: all over again. The last attempt stays as it is.
            if n == n_rooms:
                break
        lay_cells(cells, w, occupied, tables.line[slot])


@kernel
def choose_room(rooms: Ints, n: int, w: int, state: State) -> int:
    """Draw one of the rooms that may be divided, by their areas; return -1 if there is none.

    Reads: state (random).
    Writes: state (random).
    """
    total = 0
    for k in range(n):
        if rooms[k, WHOLE] == 0:
            total += (rooms[k, RIGHT] - rooms[k, LEFT]) * (rooms[k, HIGH] - rooms[k, LOW])
    if total == 0:
        return -1
    drawn = integer(state.random, w, 0, total)
    for k in range(n):
        if rooms[k, WHOLE] == 0:
            drawn -= (rooms[k, RIGHT] - rooms[k, LEFT]) * (rooms[k, HIGH] - rooms[k, LOW])
            if drawn < 0:
                return k
    return -1


@kernel
def share_across(room: Ints) -> float:
    """Return the probability that a room is divided by a wall along y: the likelier, the wider it is."""
    # Cubes make it rare that a long room is divided lengthwise.
    width, height = float(room[RIGHT] - room[LEFT]) ** 3, float(room[HIGH] - room[LOW]) ** 3
    return width / (width + height)


@kernel
def divide(occupied: Flags, rooms: Ints, k: int, n: int, axis: int, options: Any, w: int, state: State) -> bool:
    """Put a wall with a door through room k, whose other half becomes room n; return whether there is a place for it.

    No wall ends at a door.

    Reads: state (random).
    Writes: rooms, state (random).

    Args:
        occupied: The cells, changed.
        rooms: The rooms, changed.
        k: The room.
        n: The number of its other half.
        axis: 0 for a wall along y, 1 for one along x.
        options: The options.
        w: World.
        state: Its random stream.
    """
    # So that the wall stands at one first index. Slices with steps give the array and its transpose one type in Numba.
    cells = occupied[::1, ::1] if axis == 0 else occupied.T[::1, ::1]
    # Columns of the table, LEFT or LOW, in and across the direction in which the room is divided.
    along, across = 2 * axis, 2 - 2 * axis
    low, high = rooms[k, across], rooms[k, across + 1]
    least = max(1, int(np.rint(options.least_side / options.resolution)))
    # Places for the wall that leave `least` cells on both sides of it.
    count = rooms[k, along + 1] - rooms[k, along] - 2 * least
    if count <= 0:
        return False
    # All places in turn, from a random one on.
    first = integer(state.random, w, 0, count)
    for i in range(count):
        place = rooms[k, along] + least + (first + i) % count
        # The cell beyond an end of the wall is free: there is a door in the wall that it would meet.
        if (low > 0 and not cells[place, low - 1]) or (high < cells.shape[1] and not cells[place, high]):
            continue
        cells[place, low:high] = True
        wide, door = open_door(cells, place, low, high, options, w, state)
        if uniform(state.random, w, 0.0, 1.0) < options.loops:
            second = integer(state.random, w, low, high - wide + 1)
            # A second door that would touch or overlap the first one is left out.
            if abs(second - door) > wide:
                cells[place, second : second + wide] = False
        for column in range(4):
            rooms[n, column] = rooms[k, column]
        rooms[n, along], rooms[k, along + 1], rooms[n, WHOLE] = place + 1, place, 0
        return True
    return False


@kernel
def open_door(cells: Flags, place: int, low: int, high: int, options: Any, w: int, state: State) -> tuple[int, int]:
    """Open a door in a wall, and return its width and where it begins.

    Reads: state (random).
    Writes: cells, state (random).

    Args:
        cells: The cells, changed.
        place: Column of the wall.
        low: Its first cell.
        high: The cell after its last one.
        options: The options.
        w: World.
        state: Its random stream.
    """
    wide = max(1, int(np.rint(uniform(state.random, w, options.door[0], options.door[1]) / options.resolution)))
    door = integer(state.random, w, low, high - min(wide, high - low) + 1)
    # Rounding may make a door wider than the wall.
    wide = min(wide, high - low)
    cells[place, door : door + wide] = False
    return wide, door


@kind
class RoomsMap(LevelMap):
    """Rooms between walls that are one cell thick; each wall has a door, so that every room can be reached."""

    draw_maps = staticmethod(draw_rooms)

    number: tuple[int, int] = option((4, 9), meaning="Bounds of the number of rooms, as far as they fit.")
    door: tuple[float, float] = option((1.0, 1.0), unit="m", meaning="Bounds of a door's width, in whole cells.")
    least_side: float = option(2.0, gt=0.0, unit="m", meaning="Minimum width of a room, in whole cells.")
    loops: float = option(0.0, ge=0.0, le=1.0, meaning="Probability that a wall has a second door.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from unordered_ranges(self, "number", least=1.0)
        yield from unordered_ranges(self, "door", least=1e-3)
        if self.number[1] > MOST_ROOMS:
            yield "number", f"must be at most {MOST_ROOMS}, got {self.number[1]}"
        if self.door[1] > self.least_side:
            yield ("door", f"must fit the shortest wall: at most least_side {self.least_side:g}, got {self.door[1]:g}")

    def occupied(self, width: float, height: float, name: str, find: Callable[[str], Path]) -> Flags:
        """Return the border, shape ``(columns, rows)``.

        Raises:
            OptionError: If there is no room for the fewest rooms.
        """
        occupied, least = bordered(self, width, height), span(self.least_side, self.resolution)
        # n rooms and n - 1 walls take n (least + 1) - 1 cells; the border takes two of all cells.
        fits = [(cells + 1 - 2 * self.border) // (least + 1) for cells in occupied.shape]
        if fits[0] * fits[1] < self.number[0]:
            raise OptionError("number", f"leaves no room: {fits[0]} x {fits[1]} rooms of least_side fit into the world")
        return occupied
