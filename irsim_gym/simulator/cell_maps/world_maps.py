"""The occupancy maps of many worlds: how one world's map is read and written.

The map of a level consists of four arrays. Their first axis is the world, or has length 1 if all worlds share the map:

- ``squares``, uint8, shape ``(n, 4, columns, rows)``: sides of the largest free squares, by quadrant. A cell is
  occupied where ``squares[w, 0]`` is 0. Columns count from the left, rows from the bottom.
- ``boxes``, int32, shape ``(n, n_boxes, 4)``: boxes that cover the occupied cells.
- ``n_boxes``, int64, shape ``(n,)``: number of used boxes.
- ``room``, float32, shape ``(n, columns, rows)``: distance of each cell's centre from the nearest occupied cell
  [m], or from the disc in it.

``CellMap`` in ``arraytypes`` describes their contents. Only ``lay_cells`` writes them: all four, from the flags of
occupied cells, for one world. A ``Model`` has them as ``map_squares``, ``map_boxes``, ``map_n_boxes`` and ``map_room``;
``model.cells`` combines them with the radius of the discs that stand for occupied cells.
"""

from irsim_gym.base.arraytypes import BodyOutline, CellMap, CellMaps, Cells, Flags, Floats, Point
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.cell_maps.cell_room import find_room
from irsim_gym.simulator.cell_maps.cells import (
    capsule_meets_cells,
    cells_are_closer,
    find_boxes,
    find_free_squares,
    outline_cells_distance,
    outline_near_cells,
    segment_cells_distance,
)


@kernel
def map_of(cells: CellMaps, w: int) -> CellMap:
    """Return the map of world w."""
    row = w if w < cells.n_boxes.shape[0] else 0
    return CellMap(
        cells.x, cells.y, cells.width, cells.height, cells.body,
        cells.squares[row], cells.boxes[row], cells.n_boxes[row], cells.room[row], cells.radius,
    )  # fmt: skip


@kernel
def lay_cells(cells: CellMaps, w: int, occupied: Flags, line: Floats) -> None:
    """Make the map of a world from its occupied cells.

    Writes: cells.

    Args:
        cells: The maps; the row of world w is written.
        w: The world.
        occupied: Occupied cells, shape ``(columns, rows)``.
        line: Scratch, shape ``(columns,)``.
    """
    row = w if w < cells.n_boxes.shape[0] else 0
    find_free_squares(occupied, cells.squares[row])
    cells.n_boxes[row] = find_boxes(occupied, cells.boxes[row])
    find_room(map_of(cells, w), line)


def most_boxes(columns: int, rows: int) -> int:
    """Return an upper bound of the number of boxes that cover any occupied cells of a map."""
    # The most runs of a column: every other cell is occupied.
    return columns * ((rows + 1) // 2)


@kernel
def capsule_meets_map(cells: Cells, w: int, ax: float, ay: float, bx: float, by: float, radius: float) -> bool:
    """Return ``capsule_meets_cells`` for the map of world w; False without maps."""
    if cells is None:
        return False
    return bool(capsule_meets_cells(map_of(cells, w), ax, ay, bx, by, radius))


@kernel
def map_distance(cells: Cells, w: int, point: Point, limit: float) -> float:
    """Return the distance [m] of a point from the occupied cells of world w, ``limit`` if it is not smaller."""
    if cells is None:
        return limit
    return float(segment_cells_distance(map_of(cells, w), point[0], point[1], point[0], point[1], limit))


@kernel
def map_is_closer(cells: Cells, w: int, point: Point, limit: float) -> bool:
    """Return ``cells_are_closer`` for the map of world w; False without maps."""
    if cells is None:
        return False
    return bool(cells_are_closer(map_of(cells, w), point, limit))


@kernel
def outline_near_map(cells: Cells, w: int, outline: BodyOutline, clearance: float) -> bool:
    """Return ``outline_near_cells`` for the map of world w; False without maps."""
    if cells is None:
        return False
    return bool(outline_near_cells(map_of(cells, w), outline, clearance))


@kernel
def outline_map_distance(cells: Cells, w: int, outline: BodyOutline, limit: float) -> float:
    """Return the distance [m] of an outline from the occupied cells of world w: 0 if they touch, at most ``limit``."""
    if cells is None:
        return limit
    return float(outline_cells_distance(map_of(cells, w), outline, limit))
