"""Bounds on the distance of a point from the occupied cells of a map, at the cost of one look-up.

For the centre of each cell, the distance to the nearest occupied cell is stored. At another point of the cell, the
distance differs by at most the distance from the centre. Most questions are answered by these bounds, the others by an
exact search.
"""

import numpy as np

from irsim_gym.base.arraytypes import CellMap, Floats
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.geometry.segments import point_segment_distance2

FARTHEST = 64
"""Maximum distance that is stored [cells]."""
DOUBT = 1e-6
"""Relative margin of the bounds, because stored distances are float32."""


@kernel
def find_room(cells: CellMap, line: Floats) -> None:
    """Write ``cells.room``: distances up to ``farthest`` [m].

    Args:
        cells: The map.
        line: Scratch, shape ``(columns,)``.
    """
    squares, room, far = cells.squares, cells.room, farthest(cells) + cells.radius
    columns, rows = room.shape
    width, height = cells.width, cells.height
    # Whole cells: from a free centre to the border of a neighbour it is half a cell less than to the neighbour's
    # centre. Discs: to their centres, and the radius is subtracted at the end.
    inset = 0.5 if cells.radius == 0.0 else 0.0
    first = (1.0 - inset) * height
    for i in range(columns):
        # First pass, column by column: the vertical distance to the nearest occupied cell, from below and from above.
        for down in range(2):
            gap = far
            for a in range(rows):
                j = rows - 1 - a if down else a
                gap = 0.0 if squares[0, i, j] == 0 else min(gap + (first if gap == 0.0 else height), far)
                room[i, j] = min(room[i, j], gap) if down else gap
    # Second pass: the least of (horizontal, vertical) distances over all columns, nearest columns first. Both passes
    # give the exact Euclidean distance (Saito and Toriwaki 1994, "New algorithms for Euclidean distance
    # transformation").
    for j in range(rows):
        for i in range(columns):
            line[i] = room[i, j]
        for i in range(columns):
            best = line[i] * line[i]
            for step in range(1, columns):
                aside = (step - inset) * width
                if aside * aside >= best:
                    break
                near = line[i - step] if i >= step else far
                near = min(near, line[i + step]) if i + step < columns else near
                best = min(best, aside * aside + near * near)
            room[i, j] = max(np.sqrt(best) - cells.radius, 0.0)


@kernel
def farthest(cells: CellMap) -> float:
    """Return the largest distance [m] that ``cells.room`` holds."""
    return float((FARTHEST - 0.5) * min(cells.width, cells.height))


@kernel
def room_about(cells: CellMap, x: float, y: float) -> tuple[float, float]:
    """Return lower and upper bounds of the distance [m] of a point from the occupied cells; 0 and inf if unknown."""
    room = cells.room
    i, j = np.floor((x - cells.x) / cells.width), np.floor((y - cells.y) / cells.height)
    if not (0.0 <= i < room.shape[0] and 0.0 <= j < room.shape[1]):
        return 0.0, np.inf
    middle = float(room[int(i), int(j)])
    aside, up = x - cells.x - (i + 0.5) * cells.width, y - cells.y - (j + 0.5) * cells.height
    away = np.sqrt(aside * aside + up * up)
    most = middle * (1.0 + DOUBT) + away * (1.0 + DOUBT)
    # The stored distance was cut off: it is a lower bound alone.
    if middle * (1.0 + DOUBT) >= farthest(cells):
        most = np.inf
    return max(middle * (1.0 - DOUBT) - away * (1.0 + DOUBT), 0.0), most


@kernel
def segment_disc_distance2(cells: CellMap, i: int, j: int, ax: float, ay: float, bx: float, by: float) -> float:
    """Return the squared distance [m2] between the segment ab, which may be a point, and the disc in a cell."""
    x, y = cells.x + (i + 0.5) * cells.width, cells.y + (j + 0.5) * cells.height
    gap = max(np.sqrt(point_segment_distance2(x, y, ax, ay, bx, by)) - cells.radius, 0.0)
    return float(gap * gap)


@kernel
def nearest_to_point2(cells: CellMap, x: float, y: float, reach: float) -> float:
    """Return the squared distance [m2] of a point from the occupied cells; inf if none is as near as ``reach`` [m].

    Column after column is looked at, from the point's own to both sides, as far as something nearer may lie in it.

    Args:
        cells: The map.
        x: The point [m].
        y: The point [m].
        reach: How far to look [m].
    """
    squares = cells.squares
    columns, rows = squares.shape[1], squares.shape[2]
    best, bound = np.inf, reach * reach * (1.0 + DOUBT)
    own_i = int(min(max(np.floor((x - cells.x) / cells.width), 0.0), columns - 1.0))
    own_j = int(min(max(np.floor((y - cells.y) / cells.height), 0.0), rows - 1.0))
    # Columns to the right from the own one on, then those to the left of it.
    for direction in range(2):
        i = own_i - direction
        while 0 <= i < columns:
            aside = max(cells.x + i * cells.width - x, x - (cells.x + (i + 1) * cells.width), 0.0)
            if aside * aside > bound:
                break
            for down in range(2):
                # Squares of quadrant 0 skip free rows upwards, those of quadrant 2 downwards.
                j = own_j
                while 0 <= j < rows:
                    up = max(cells.y + j * cells.height - y, y - (cells.y + (j + 1) * cells.height), 0.0)
                    free, near = int(squares[2 * down, i, j]), aside * aside + up * up
                    if free == 0 or near > bound:
                        if cells.radius > 0.0 and near <= bound:
                            near = segment_disc_distance2(cells, i, j, x, y, x, y)
                        best = min(best, near) if near <= bound else best
                        break
                    j += free - 2 * down * free
                bound = min(best, bound)
            i += 1 - 2 * direction
    return best
