"""Short names for array types by what they hold, and the records that kernels of several parts read."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Rays = NDArray[np.float32]
Ints = NDArray[np.int64]
Spans = NDArray[np.int32]
Flags = NDArray[np.bool_]
Bytes = NDArray[np.uint8]
Labels = NDArray[np.int32]
Words = NDArray[np.uint64]
Pixels = NDArray[np.uint32]
Record = np.record
Records = NDArray[np.record]

Point = tuple[float, float]
"""x and y [m]."""
Vector = tuple[float, float]
"""Both parts of a vector, such as a velocity [m/s]."""
Pose = tuple[float, float, float]
"""x, y [m] and heading [rad]."""

# Arrays of one record, not named tuples: fields of the model are copied, compared and stored as arrays.
MAP_FRAME = np.dtype((np.record, "f8, f8, f8, f8, i8"))
MAP_FRAME.names = "x", "y", "width", "height", "body"
"""Where an occupancy map lies: its lower left corner, width and height of a cell [m]; its body, -1 without a map."""

BUCKET_FRAME = np.dtype((np.record, "f8, f8, f8, i8, i8, f8"))
BUCKET_FRAME.names = "x", "y", "side", "columns", "rows", "reach"
"""Where the squares of ``simulator.geometry.buckets`` lie: lower left corner and side [m], numbers of columns and rows
(0 without buckets), and the greatest reach of the bodies in them [m]."""


class CellMap(NamedTuple):
    """An occupancy map: equal rectangles, of which some are occupied. What lies outside of it is free.

    Attributes:
        x: Left end [m].
        y: Lower end [m].
        width: Width of a cell [m].
        height: Height of a cell [m].
        body: The map's body.
        squares: Side of the largest free square that has the cell in column i (from the left) and row j (from the
            bottom) in its corner and grows into a quadrant: 0 to the upper right, 1 to the upper left, 2 to the lower
            right, 3 to the lower left; 0 where the cell is occupied, at most 255. Shape ``(4, columns, rows)``.
        boxes: Boxes that cover the occupied cells: first column, end column, first row, end row, shape ``(n, 4)``.
        n_boxes: How many rows of ``boxes`` count.
        room: Distance of each cell's centre from the nearest occupied cell [m], see ``simulator.cell_maps.cell_room``,
            shape ``(columns, rows)``.
        radius: 0 where occupied cells are occupied all over; else each of them holds a disc of this radius [m] in its
            middle, at most half a cell, and the rest of it is free.
    """

    x: float
    y: float
    width: float
    height: float
    body: int
    squares: Bytes
    boxes: Spans
    n_boxes: int
    room: Rays
    radius: float


class CellMaps(NamedTuple):
    """The occupancy maps of all worlds: as ``CellMap``, with the world as the first axis of each array.

    A first axis of length 1 means that all worlds share the map; ``simulator.cell_maps.world_maps.map_of`` returns that
    of one.

    Attributes:
        x: Left end [m].
        y: Lower end [m].
        width: Width of a cell [m].
        height: Height of a cell [m].
        body: The map's body.
        squares: Free squares, shape ``(n, 4, columns, rows)``.
        boxes: Boxes of occupied cells, shape ``(n, n_boxes, 4)``.
        n_boxes: How many of these boxes count, shape ``(n,)``.
        room: Distances from the occupied cells [m], shape ``(n, columns, rows)``.
        radius: Radius of the discs that stand for occupied cells [m], 0 where these are occupied all over.
    """

    x: float
    y: float
    width: float
    height: float
    body: int
    squares: Bytes
    boxes: Spans
    n_boxes: Ints
    room: Rays
    radius: float


Cells = CellMaps | None
"""Those of a scenario, which may have no obstacle map."""


class BodyOutline(NamedTuple):
    """The outline of a body: rows of a table of segments and rows of a table of discs.

    Attributes:
        segments: x0, y0, x1, y1 [m], shape ``(segment, 4)``.
        first_segment: The first row of the body.
        n_segments: Number of its rows.
        discs: x, y, radius [m], shape ``(disc, 3)``.
        first_disc: The first row of the body.
        n_discs: Number of its rows.
        solid: The segments bound an area (closed chains, inside by the even-odd rule); else they are curves.
    """

    segments: Floats
    first_segment: int
    n_segments: int
    discs: Floats
    first_disc: int
    n_discs: int
    solid: bool
