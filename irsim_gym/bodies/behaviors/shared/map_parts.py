"""The parts of an occupancy map for behaviours: the walls of its cells, or the discs in them."""

import numpy as np

from irsim_gym.simulator.cell_maps.cells import cell_range
from irsim_gym.simulator.world.names import Bytes, CellMaps, Floats, Model, kernel, row_of


def most_map_walls(model: Model, threshold: float) -> int:
    """Return an upper bound of the number of map walls within ``threshold`` [m] of a point; discs have none."""
    if (chart := model.cells) is None or chart.radius > 0.0:
        return 0
    columns, rows = _most_cells(chart, threshold)
    # In each of rows + 1 lines at most `columns` walls, in each of columns + 1 lines at most `rows`; 1 for rounding.
    return int(2.0 * (columns + 1.0) * (rows + 1.0)) + 1


def most_map_discs(model: Model, threshold: float) -> int:
    """Return an upper bound of the number of map discs whose centres are within ``threshold`` [m] of a point."""
    if (chart := model.cells) is None or chart.radius == 0.0:
        return 0
    columns, rows = _most_cells(chart, threshold)
    return int(columns) * int(rows)


def _most_cells(chart: CellMaps, threshold: float) -> tuple[float, float]:
    """Return upper bounds of the columns and rows of a map that come within ``threshold`` [m] of a point."""
    columns, rows = (
        min(float(count), 2.0 * threshold / side + 2.0)
        for count, side in zip(chart.room.shape[1:], (chart.width, chart.height), strict=True)
    )
    return columns, rows


@kernel
def map_walls(model: Model, w: int, x: float, y: float, threshold: float, sides: Floats, n_sides: int) -> int:
    """Append the borders between occupied and free cells near a point to ``sides``; return how many those are now.

    Borders in a line are one segment, with the free cells to its left. What lies outside of the map is free. Those for
    which ``sides`` has no more rows are left out. There are none where discs stand in the occupied cells.

    Reads: model (map_disc, map_frame, map_squares).
    Writes: sides.

    Args:
        model: The map.
        w: World.
        x: The point [m].
        y: The point [m].
        threshold: Borders of cells that are nearer than this [m].
        sides: Written, x0, y0, x1, y1 [m], shape ``(n, 4)``.
        n_sides: Number of rows in use.
    """
    if model.map_disc[0] > 0.0:
        return n_sides
    frame, squares = model.map_frame[0], model.map_squares[row_of(model.map_squares, w)]
    for axis in range(2):
        # Axis 0: lines along x, between rows of cells; axis 1: lines along y. `across` is where the line begins.
        low, across = (frame.y, frame.x) if axis == 0 else (frame.x, frame.y)
        pitch, width = (frame.height, frame.width) if axis == 0 else (frame.width, frame.height)
        height, place = (y, x) if axis == 0 else (x, y)
        # Axis 1 of `squares` is the column and axis 2 the row.
        lines, cells = squares.shape[2 - axis], squares.shape[1 + axis]
        first = int(max(np.ceil((height - threshold - low) / pitch), 0.0))
        last = int(min(np.floor((height + threshold - low) / pitch), float(lines)))
        for line in range(first, last + 1):
            level = low + line * pitch
            # Half the chord that the disc about the point cuts from the line.
            half = np.sqrt(max(threshold * threshold - (level - height) * (level - height), 0.0))
            begin = int(max(np.floor((place - half - across) / width), 0.0))
            end = int(min(np.floor((place + half - across) / width), cells - 1.0))
            start, going = begin, 0
            # One cell beyond the end closes the last wall.
            for cell in range(begin, end + 2):
                border = 0
                if cell <= end:
                    # 1: occupied beyond the line only; -1: before it only; 0: no border.
                    border = int(is_occupied(squares, axis, cell, line)) - int(
                        is_occupied(squares, axis, cell, line - 1)
                    )
                if border == going:
                    continue
                if going != 0:
                    if n_sides == sides.shape[0]:
                        return n_sides
                    along0, along1 = across + start * width, across + cell * width
                    # The direction in which the free cells lie to the left; x and y swap the sense of turning.
                    if (going > 0) == (axis == 0):
                        along0, along1 = along1, along0
                    sides[n_sides, axis], sides[n_sides, 1 - axis] = along0, level
                    sides[n_sides, 2 + axis], sides[n_sides, 3 - axis] = along1, level
                    n_sides += 1
                start, going = cell, border
    return n_sides


@kernel
def is_occupied(squares: Bytes, axis: int, cell: int, line: int) -> bool:
    """Return whether a cell is occupied: number ``cell`` along row (axis 0) or column (axis 1) number ``line``."""
    if line < 0 or line >= squares.shape[2 - axis]:
        return False
    # Layer 0 is as good as any: in all of them, 0 says that the cell is occupied.
    return bool((squares[0, cell, line] if axis == 0 else squares[0, line, cell]) == 0)


@kernel
def map_discs(model: Model, w: int, x: float, y: float, threshold: float, discs: Floats) -> int:
    """Write the discs of a map whose centres are near a point, column by column; return their number.

    There are none where occupied cells are occupied all over.

    Reads: model (map_disc, map_frame, map_squares).
    Writes: discs.

    Args:
        model: The map.
        w: World.
        x: The point [m].
        y: The point [m].
        threshold: Centres that are nearer than this [m].
        discs: Written, x, y, radius [m], shape ``(n, 3)``.
    """
    radius, count = model.map_disc[0], 0
    if radius == 0.0:
        return count
    frame, squares = model.map_frame[0], model.map_squares[row_of(model.map_squares, w)]
    first_i, last_i = cell_range(x - threshold, x + threshold, frame.x, frame.width, squares.shape[1])
    first_j, last_j = cell_range(y - threshold, y + threshold, frame.y, frame.height, squares.shape[2])
    for i in range(first_i, last_i + 1):
        cx, j = frame.x + (i + 0.5) * frame.width, first_j
        while j <= last_j:
            if squares[0, i, j] > 0:
                # The side of a free square with this cell in its lower left: as many cells of the column are free.
                j += int(squares[0, i, j])
                continue
            cy = frame.y + (j + 0.5) * frame.height
            if (x - cx) * (x - cx) + (y - cy) * (y - cy) < threshold * threshold:
                discs[count, 0], discs[count, 1], discs[count, 2] = cx, cy, radius
                count += 1
            j += 1
    return count
