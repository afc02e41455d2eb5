"""Beams in an occupancy map: steps from free square to free square, exact at the boundaries of cells.

For each free cell and each of the four diagonal directions, the map holds the largest free square with this cell in its
corner. A beam that stands in the cell and looks in that direction meets nothing inside the square, so it may go on to
where it leaves the square.

Beams are treated in blocks. All beams of a block advance by one square at a time, so that the compiler can use vector
instructions. The numbers of a block lie in one array of floats and one of integers, at constant offsets (``EAST`` and
so on): with one array for each number, the compiler could not rule out that they overlap. Beams that look left or down
are mirrored together with the map, so that all beams go right and up. Numbers are float32, relative to the cell of the
sensor.
"""

from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Bytes, CellMap, Labels, Pose, Rays
from irsim_gym.base.kernels import kernel

STEEP = 1e30
"""Stands for the inverse of a velocity of 0 along an axis [m/cells]."""


LANES = 32
"""Number of beams in a block."""
EAST, NORTH, SLOW_X, SLOW_Y = 0, LANES, 2 * LANES, 3 * LANES
TIME, FAR, COLUMN, ROW = 4 * LANES, 5 * LANES, 6 * LANES, 7 * LANES
PLACE_X, PLACE_Y, COLUMNS, ROWS = 8 * LANES, 9 * LANES, 10 * LANES, 11 * LANES
FIRST, STEP_X, STEP_Y, CELL, FREE = 0, LANES, 2 * LANES, 3 * LANES, 4 * LANES
N_FLOATS, N_INTEGERS = 12 * LANES, 5 * LANES

NONE, ONE, FLAT = np.float32(0.0), np.float32(1.0), np.float32(1.0 / STEEP)
EDGE = np.float32(1.0 - 2.0**-24)
"""Largest coordinate inside a cell."""


@kernel
def cast_cells(
    cells: CellMap, pose: Pose, beams_x: Rays, beams_y: Rays, floats: Rays, integers: Labels, ranges: Rays
) -> None:
    """Shorten ``ranges`` to the nearest occupied cell.

    A beam that starts in an occupied cell ends where it leaves the occupied cells.

    Args:
        cells: The map.
        pose: The sensor's x, y, heading [m, m, rad].
        beams_x: Unit directions in the sensor frame, at least as many as ranges.
        beams_y: As ``beams_x``.
        floats: Scratch, shape ``(N_FLOATS,)``.
        integers: Scratch, shape ``(N_INTEGERS,)``.
        ranges: Changed: ranges [m], shape ``(n_beams,)``. Cells beyond the range given here are not searched.
    """
    squares, boxes = cells.squares, cells.boxes
    if cells.n_boxes == 0:
        return
    columns, rows = squares.shape[1], squares.shape[2]
    x, y, heading = pose
    cosine, sine = np.cos(heading), np.sin(heading)
    across, up = (x - cells.x) / cells.width, (y - cells.y) / cells.height
    # Blocks begin in a free cell of the map, and their cells are occupied all over, as discs need an exact test in each
    # occupied cell. All other beams are cast one by one.
    is_within = 0.0 <= across < columns and 0.0 <= up < rows
    if cells.radius > 0.0 or not is_within or squares[0, int(across), int(up)] == 0:
        for k in range(ranges.shape[0]):
            along_x, along_y = cosine * beams_x[k] - sine * beams_y[k], sine * beams_x[k] + cosine * beams_y[k]
            ranges[k] = np.float32(walk(cells, x, y, along_x, along_y, np.float64(ranges[k])))
        return
    turn = (
        np.float32(cosine / cells.width), np.float32(sine / cells.width),
        np.float32(cosine / cells.height), np.float32(sine / cells.height),
    )  # fmt: skip
    # Any occupied cell will do: the first cell of the first box. ``every`` numbers cells by quadrant, column and row.
    occupied = np.int32(boxes[0, 0] * rows + boxes[0, 2])
    every = squares.reshape(-1)
    for begin in range(0, ranges.shape[0], LANES):
        take_beams(begin, beams_x, beams_y, ranges, floats)
        begin_block(turn, across, up, squares, floats, integers)
        walk_block(every, occupied, floats, integers)
        end_block(begin, floats, ranges)


@kernel
def take_beams(begin: int, beams_x: Rays, beams_y: Rays, ranges: Rays, floats: Rays) -> None:
    """Write the directions and ranges [m] of a block of beams in the sensor frame. Unused places get range 0."""
    count = min(LANES, ranges.shape[0] - begin)
    along_x, along_y, far = beams_x[begin : begin + count], beams_y[begin : begin + count], ranges[begin:]
    for k in range(count):
        floats[EAST + k], floats[NORTH + k], floats[FAR + k] = along_x[k], along_y[k], far[k]
    for k in range(count, LANES):
        # Range 0 ends a place that has no beam at once.
        floats[EAST + k], floats[NORTH + k], floats[FAR + k] = ONE, ONE, NONE


@kernel(contract=True)
def begin_block(turn: Any, across: float, up: float, squares: Bytes, floats: Rays, integers: Labels) -> None:
    """Rotate the beams of a block into the map frame [cells/m], and start them in the cell of their sensor.

    Args:
        turn: Cosine and sine of the sensor's heading over the width of a cell, and over its height [1/m].
        across: The sensor's place [cells].
        up: The sensor's place [cells].
        squares: See ``CellMap``.
        floats: The block, changed.
        integers: The block, changed.
    """
    cosine_x, sine_x, cosine_y, sine_y = turn
    i, j, columns, rows = int(across), int(up), squares.shape[1], squares.shape[2]
    free_0, free_1 = np.int32(squares[0, i, j]), np.int32(squares[1, i, j])
    free_2, free_3 = np.int32(squares[2, i, j]), np.int32(squares[3, i, j])
    # Place within the first cell, below 1 even after rounding to float32. Columns and rows count from this cell on.
    aside, above = min(np.float32(across - i), EDGE), min(np.float32(up - j), EDGE)
    right, left, high, low = np.float32(columns - i), np.float32(i + 1), np.float32(rows - j), np.float32(j + 1)
    row, size, none = np.int32(rows), np.int32(columns * rows), np.int32(0)
    cell, twice = np.int32(i * rows + j), np.int32(2 * columns * rows)
    for k in range(LANES):
        east = cosine_x * floats[EAST + k] - sine_x * floats[NORTH + k]
        north = sine_y * floats[EAST + k] + cosine_y * floats[NORTH + k]
        # Mirrored, every beam goes right and up: speeds [cells/m] and their inverses, with a finite one for 0.
        fast_x, fast_y = east if east >= NONE else -east, north if north >= NONE else -north
        floats[EAST + k], floats[NORTH + k] = fast_x, fast_y
        floats[SLOW_X + k] = ONE / (fast_x if fast_x > FLAT else FLAT)
        floats[SLOW_Y + k] = ONE / (fast_y if fast_y > FLAT else FLAT)
        floats[TIME + k], floats[COLUMN + k], floats[ROW + k] = NONE, NONE, NONE
        floats[PLACE_X + k] = aside if east >= NONE else ONE - aside
        floats[PLACE_Y + k] = above if north >= NONE else ONE - above
        # Number of columns, and rows, from the sensor's own to the border that the beam goes to.
        floats[COLUMNS + k] = right if east >= NONE else left
        floats[ROWS + k] = high if north >= NONE else low
        # Numbers in the flat table: quadrant 0 to 3 begins at 0, 1, 2, 3 times ``size``; a column is ``row`` entries.
        quadrant = np.int32(cell + (none if east >= NONE else size))
        integers[FIRST + k] = np.int32(quadrant + (none if north >= NONE else twice))
        integers[STEP_X + k] = row if east >= NONE else np.int32(-row)
        integers[STEP_Y + k] = np.int32(1) if north >= NONE else np.int32(-1)
        free = (free_0 if east >= NONE else free_1) if north >= NONE else (free_2 if east >= NONE else free_3)
        integers[FREE + k] = free if floats[FAR + k] > NONE else none


@kernel(contract=True)
def walk_block(squares: Bytes, occupied: Any, floats: Rays, integers: Labels) -> None:
    """Advance each beam of a block from free square to free square until all have ended.

    A beam that meets something stays where it is. One that leaves the map is far away.

    Args:
        squares: Sides of the free squares, flat: see ``cells``.
        occupied: Number of an occupied cell, for beams that came to their end: they go nowhere from there.
        floats: The block, changed.
        integers: The block, changed.
    """
    some = 1
    while some > 0:
        for k in range(LANES):
            time, i, j, free = floats[TIME + k], floats[COLUMN + k], floats[ROW + k], np.float32(integers[FREE + k])
            # The free square ends before column to_i and row to_j; the beam leaves it where it meets the first of both.
            to_i, to_j = i + free, j + free
            time_x = (to_i - floats[PLACE_X + k]) * floats[SLOW_X + k]
            time_y = (to_j - floats[PLACE_Y + k]) * floats[SLOW_Y + k]
            leaves_x = time_x < time_y
            then = time_x if leaves_x else time_y
            # Rounding must not let a beam go back.
            then = then if then > time else time
            # The cell along the side that the beam leaves through, which rounding must not move out of the square.
            beside = np.float32(np.int32(floats[PLACE_X + k] + then * floats[EAST + k]))
            beside = beside if beside > i else i
            beside = beside if beside < to_i - ONE else to_i - ONE
            above = np.float32(np.int32(floats[PLACE_Y + k] + then * floats[NORTH + k]))
            above = above if above > j else j
            above = above if above < to_j - ONE else to_j - ONE
            next_i, next_j = to_i if leaves_x else beside, above if leaves_x else to_j
            # A beam that leaves the map gets its whole range: it meets nothing any more.
            then = then if (next_i < floats[COLUMNS + k]) & (next_j < floats[ROWS + k]) else floats[FAR + k]
            # A beam that has ended (``free`` 0) keeps its place, as lanes cannot stop one by one.
            time, i, j = then if free > NONE else time, next_i if free > NONE else i, next_j if free > NONE else j
            floats[TIME + k], floats[COLUMN + k], floats[ROW + k] = time, i, j
            along_x = np.int32(np.int32(i) * integers[STEP_X + k])
            along_y = np.int32(np.int32(j) * integers[STEP_Y + k])
            cell = np.int32(np.int32(integers[FIRST + k] + along_x) + along_y)
            # A beam at its range is sent to an occupied cell, where the next ``free`` is 0.
            integers[CELL + k] = cell if time < floats[FAR + k] else occupied
        some = 0
        for k in range(LANES):
            # The look-ups are in a loop of their own, so that the arithmetic above is vectorised.
            integers[FREE + k] = squares[np.uint32(integers[CELL + k])]
            some |= int(integers[FREE + k])


@kernel
def end_block(begin: int, floats: Rays, ranges: Rays) -> None:
    """Shorten the ranges to where the beams of a block have ended."""
    count = min(LANES, ranges.shape[0] - begin)
    block = ranges[begin : begin + count]
    for k in range(count):
        block[k] = floats[TIME + k] if floats[TIME + k] < block[k] else block[k]


@kernel
def walk(cells: CellMap, x: float, y: float, along_x: float, along_y: float, far: float) -> float:
    """Return how far a point goes until it meets an occupied cell, or the disc in one, at most ``far`` [m].

    From within occupied cells it goes until it leaves them; from within a disc, until it leaves that.

    Args:
        cells: The map.
        x: Position [m].
        y: Position [m].
        along_x: Unit vector of its way.
        along_y: Unit vector of its way.
        far: Longest way [m].
    """
    squares = cells.squares
    columns, rows = squares.shape[1], squares.shape[2]
    across, up = (x - cells.x) / cells.width, (y - cells.y) / cells.height
    east, north = along_x / cells.width, along_y / cells.height
    slow_x = 1.0 / east if abs(east) > 1.0 / STEEP else STEEP
    slow_y = 1.0 / north if abs(north) > 1.0 / STEEP else STEEP
    time = entry(across, up, slow_x, slow_y, float(columns), float(rows))
    if time >= far:
        return far
    step_x, step_y = 1 if east >= 0.0 else -1, 1 if north >= 0.0 else -1
    quadrant = (0 if step_x > 0 else 1) + (0 if step_y > 0 else 2)
    i, j = first_cell(across + time * east, step_x, columns), first_cell(up + time * north, step_y, rows)
    # From within occupied cells, the beam looks for the first free cell instead, one cell at a time.
    inside = cells.radius == 0.0 and time == 0.0 and squares[0, i, j] == 0
    while time < far:
        free = int(squares[quadrant, i, j])
        if cells.radius == 0.0:
            if (free == 0) != inside:
                return time
        elif free == 0:
            # Cells whose disc is not met are crossed like free ones, one at a time.
            hit = way_to_disc(cells, i, j, x, y, along_x, along_y)
            if hit < np.inf:
                return min(hit, far)
        reach = 1 if inside else max(free, 1)
        to_i, to_j = i + step_x * reach, j + step_y * reach
        # Cell to_i is the first one behind the square; a beam to the right meets its left border, and the other way
        # round.
        time_x = ((to_i if step_x > 0 else to_i + 1) - across) * slow_x
        time_y = ((to_j if step_y > 0 else to_j + 1) - up) * slow_y
        if time_x < time_y:
            time = max(time, time_x)
            beside = int(np.floor(up + time * north))
            # The row is kept between the one that the beam came from and the last one of the square.
            i, j = to_i, min(max(beside, j), to_j - 1) if step_y > 0 else max(min(beside, j), to_j + 1)
        else:
            time = max(time, time_y)
            beside = int(np.floor(across + time * east))
            j, i = to_j, min(max(beside, i), to_i - 1) if step_x > 0 else max(min(beside, i), to_i + 1)
        if i < 0 or j < 0 or i >= columns or j >= rows:
            return min(time, far) if inside else far
    return far


@kernel
def way_to_disc(cells: CellMap, i: int, j: int, x: float, y: float, along_x: float, along_y: float) -> float:
    """Return the distance [m] along a ray to the disc in a cell; from inside to its edge; inf if the ray misses it."""
    dx, dy = cells.x + (i + 0.5) * cells.width - x, cells.y + (j + 0.5) * cells.height - y
    along, aside = dx * along_x + dy * along_y, dx * along_y - dy * along_x
    # Half of the chord that the ray's line cuts out of the disc, squared.
    half2 = cells.radius * cells.radius - aside * aside
    if half2 < 0.0:
        return np.inf
    half = np.sqrt(half2)
    if dx * dx + dy * dy <= cells.radius * cells.radius:
        return float(along + half)
    return float(along - half) if along > 0.0 else np.inf


@kernel
def entry(x: float, y: float, slow_x: float, slow_y: float, columns: float, rows: float) -> float:
    """Return the time at which a point enters the map: 0 if it is within, inf if it never does."""
    if 0.0 <= x < columns and 0.0 <= y < rows:
        return 0.0
    # The slab method: times at which the point's line crosses the four borders; it is within the map between the later
    # entry and the earlier exit.
    left, right = -x * slow_x, (columns - x) * slow_x
    low, high = -y * slow_y, (rows - y) * slow_y
    enter = max(min(left, right), min(low, high), 0.0)
    leave = min(max(left, right), max(low, high))
    return enter if enter < leave else np.inf


@kernel
def first_cell(place: float, step: int, count: int) -> int:
    """Return which of ``count`` cells holds a point; on a boundary, the one that the point moves into."""
    cell = np.floor(place) if step > 0 else np.ceil(place) - 1.0
    return int(min(max(cell, 0.0), count - 1.0))
