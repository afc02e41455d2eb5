"""Compute the exact coverage of pixels by areas from the edges of these areas, and paint with it.

An area is drawn in two steps. First, each edge of its boundary adds its change of coverage to a *sheet*: in each row
the height that it crosses, shared between the pixel that it crosses and the next one. A running sum along the row
then gives the part of each pixel within the boundary, times the number of turns of the boundary around it.
``paint`` sums, blends a colour into the picture and leaves the sheet empty. (FreeType and libart sum signed areas in
the same way; see R. Levien, "Inside the fastest font renderer in the world", 2016.)

A sheet is float32 and one row taller than its picture. Its first columns belong to pixels; the columns after them flag
the tiles of ``TILE`` columns that hold anything, so that the inside of an area need not be summed. The last row, the
header, holds the range of touched rows and columns, in 4 numbers. ``new_sheet`` makes a sheet; each thread
needs its own. ``cover`` walks over a sheet and calls the kernels that blend a colour into pixels of a row.

Positions are in pixels from the upper left corner of the picture, x to the right and y down; the centre of the first
pixel is 0.5, 0.5. A *box* is int64 ``(4,)``: first column, first row, end column, end row, all within the picture;
nothing outside is painted. A *colour* is float64 ``(n_channels + 1,)``: the channels' values [0, 255], then an opacity
[0, 1].
"""

from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Ints, Rays
from irsim_gym.base.kernels import kernel

TILE_BITS = 4
TILE = 1 << TILE_BITS
# A colour, and its first three channels as 16-bit numbers.
Ink = tuple[Floats, Any, Any, Any]
# Half of 256, so that the division by 256 (``>> 8``) rounds to the nearest number.
MIDDLE = np.uint16(128)
FARTHEST = 1e9
SLACK = 1e-3
"""Rounding can move the crossing of an edge with a row beyond the edge's ends by less than this [pixel]."""
NOTHING, HALF, ONE, TWO, WHOLE = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0), np.float32(256.0)


def new_sheet(height: int, width: int) -> Rays:
    """Return an empty sheet for pictures of this size [pixel]."""
    tiles = width // TILE + 1
    return np.zeros((height + 1, tiles * (TILE + 1)), np.float32)


@kernel
def add_edge(sheet: Rays, box: Ints, ax: float, ay: float, bx: float, by: float) -> None:
    """Add a directed edge from a to b [pixel] to a sheet; the edges of an area must form closed loops.

    Parts left of the box count as if they were on its left side; parts to the right, above or below do not count.
    """
    note(sheet, box, min(ax, bx), min(ay, by), max(ax, bx), max(ay, by))
    scan_edge(sheet, box, ax, ay, bx, by)


@kernel
def note(sheet: Rays, box: Ints, left: float, top: float, right: float, foot: float) -> None:
    """Note the region of edges to be added, within these sides [pixel]; it may be larger than necessary."""
    header, width = sheet.shape[0] - 1, sheet.shape[1] * TILE // (TILE + 1)
    if not (left < box[2] and foot > box[1] and top < box[3]):
        return
    # An edge changes the pixel that it crosses and the one to the right of it, hence two columns beyond ``right``.
    first_row, end_row = max(int(max(top, 0.0)), box[1]), min(int(min(foot, float(box[3]))) + 1, box[3])
    left -= SLACK
    first, end = max(int(max(left, 0.0)), box[0]), min(int(min(max(right, float(box[0])), float(box[2]))) + 2, width)
    # Numbers of the header only grow, from 0 if empty: first row and column are distances from the other end.
    sheet[header, 0] = max(sheet[header, 0], np.float32(header - first_row))
    sheet[header, 1] = max(sheet[header, 1], np.float32(end_row))
    sheet[header, 2] = max(sheet[header, 2], np.float32(width - first))
    sheet[header, 3] = max(sheet[header, 3], np.float32(end))


@kernel(inlined=True)
def scan_edge(sheet: Rays, box: Ints, ax: float, ay: float, bx: float, by: float) -> None:
    """Add an edge within the noted region; see ``add_edge``."""
    # Edges that go up count negative, so the two sides of an area cancel beyond it.
    sign = 1.0
    if ay > by:
        ax, ay, bx, by, sign = bx, by, ax, ay, -1.0
    x_low, y_low, x_high, y_high = float(box[0]), float(box[1]), float(box[2]), float(box[3])
    if not (by > ay and by > y_low and ay < y_high and min(ax, bx) < x_high and abs(ax) + abs(bx) < FARTHEST):
        return
    slope = (bx - ax) / (by - ay)
    x, end_x = ax, bx
    if ay < y_low:
        x, ay = ax + slope * (y_low - ay), y_low
    if by > y_high:
        end_x, by = bx - slope * (by - y_high), y_high
    width, row, last = sheet.shape[1] * TILE // (TILE + 1), int(ay), min(int(by), box[3] - 1)
    while row < last:
        foot = float(row + 1)
        next_x = x + slope * (foot - ay)
        _cross(sheet, width, row, x, next_x, sign * (foot - ay), x_low, x_high)
        x, ay, row = next_x, foot, row + 1
    if by > ay:
        _cross(sheet, width, row, x, end_x, sign * (by - ay), x_low, x_high)


@kernel(inlined=True)
def _cross(
    sheet: Rays, width: int, row: int, x: float, end_x: float, height: float, x_low: float, x_high: float
) -> None:
    """Add the part of an edge within a row; ``height`` is the signed height of the row that it crosses."""
    low, high = min(x, end_x), max(x, end_x)
    column = int(max(low, x_low))
    # The usual case: the whole part lies in one pixel. ``share`` is its mean distance from the left side of the pixel.
    if low >= x_low and high <= float(column + 1) and high < x_high:
        _deposit(sheet, width, row, column, height, 0.5 * (low + high) - float(column))
        return
    # Left of the box: all pixels of the row lie to the right of the edge.
    if high <= x_low:
        sheet[np.uint64(row), np.uint64(column)] += np.float32(height)
        sheet[np.uint64(row), np.uint64(width + column // TILE)] = ONE
        return
    per_column = height / (high - low) if high > low else 0.0
    line, carried = sheet[np.uint64(row)], 0.0
    first, place, high = column, max(low, x_low), min(high, x_high)
    if not place < high:
        return
    # The part to the left of the box counts in full from the first column on.
    if low < x_low:
        line[np.uint64(column)] += np.float32(per_column * (x_low - low))
    while place < high:
        until = min(float(column + 1), high)
        part = per_column * (until - place)
        # In the pixel, only what is right of the edge is covered; the rest of ``part`` is carried to the next one.
        right = part * (0.5 * (place + until) - float(column))
        line[np.uint64(column)] += np.float32(carried + part - right)
        place, carried, column = until, right, column + 1
    line[np.uint64(column)] += np.float32(carried)
    for tile in range(first // TILE, column // TILE + 1):
        line[np.uint64(width + tile)] = ONE


@kernel(inlined=True)
def _deposit(sheet: Rays, width: int, row: int, column: int, height: float, share: float) -> None:
    """Add the height that an edge crosses within a pixel, on average ``share`` of its width from its left side."""
    # The edge covers the pixel to its right only; the rest of the height comes in with the next pixel.
    line, right = sheet[np.uint64(row)], height * share
    line[np.uint64(width + column // TILE)] = ONE
    line[np.uint64(width + (column + 1) // TILE)] = ONE
    line[np.uint64(column)] += np.float32(height - right)
    line[np.uint64(column + 1)] += np.float32(right)


@kernel(inlined=True)
def paint(picture: Bytes, sheet: Rays, box: Ints, colour: Floats, even_odd: bool) -> None:
    """Blend a colour into a picture where a sheet's areas are, and leave the sheet empty.

    Args:
        picture: uint8, shape ``(height, width, n_channels)``.
        sheet: Areas whose edges were added with the same box.
        box: Part of the picture that may change.
        colour: Colour and opacity.
        even_odd: If true, a point lies within an area if the boundary winds around it an odd number of times; if false,
            if it winds around it a nonzero number of times.
    """
    last = picture.shape[2]  # place of the opacity; with fewer than three channels it stands in for the missing ones
    red, green, blue = colour[0] + 0.5, colour[min(1, last)] + 0.5, colour[min(2, last)] + 0.5
    ink = colour, np.uint16(red), np.uint16(green), np.uint16(blue)
    cover(picture, sheet, box, even_odd, float(colour[last]), ink, blend_channels, fill_channels)


@kernel(inlined=True)
def cover(
    picture: Any, sheet: Rays, box: Ints, even_odd: bool, opacity: float, ink: Any, blend: Any, fill: Any
) -> None:
    """Walk over the rows of a picture in which a sheet has areas, blend an ink in, and leave the sheet empty.

    Args:
        picture: Picture; its first axis is rows, its second axis columns.
        sheet: Areas.
        box: Part of the picture that may change.
        even_odd: See ``paint``.
        opacity: Opacity of the ink [0, 1].
        ink: Ink to blend in, as ``blend`` and ``fill`` take it.
        blend: Kernel that blends the ink into a range of columns of a row, beginning with a tile, by the row's sums.
        fill: Kernel that blends the ink into a range of columns with one share of 256 parts.
    """
    first_row, end_row, first_tile, end_tile = sum_rows(sheet, even_odd)
    width, whole = sheet.shape[1] * TILE // (TILE + 1), WHOLE * np.float32(min(max(opacity, 0.0), 1.0))
    for row in range(first_row, end_row):
        share, painted = np.int32(0), box[2]
        sums, line = sheet[np.uint64(row)], picture[np.uint64(row)]
        for number in range(np.uint64(width + first_tile), np.uint64(width + end_tile)):
            tile = int(sums[number]) - 1
            if tile < 0:
                break
            column = tile << TILE_BITS
            # Between two touched tiles the sum does not change: one share fills all of it.
            if share > 0 and painted < column:
                fill(line, painted, min(column, box[2]), ink, share)
            painted = column + TILE
            blend(line, column, min(painted, box[2]), ink, whole, sums)
            share = np.int32(min(abs(sums[np.uint64(painted - 1)]), ONE) * whole + HALF)
            sums[number] = NOTHING
            for place in range(np.uint64(TILE)):
                sums[np.uint64(column) + place] = NOTHING
        if share > 0:
            fill(line, painted, box[2], ink, share)


@kernel
def sum_rows(sheet: Rays, even_odd: bool) -> tuple[int, int, int, int]:
    """Turn the changes of coverage in a sheet into the signed winding number of the boundary around each pixel.

    With the even-odd rule the result is the coverage. Only tiles that hold anything are written. In each row their
    numbers, counted from 1, replace the flags from the first noted tile on; a 0 follows if there is room.

    Returns:
        First and end row, first and end tile of the written region; the header is empty again.
    """
    header, width = sheet.shape[0] - 1, sheet.shape[1] * TILE // (TILE + 1)
    first_row, end_row = header - int(sheet[header, 0]), int(sheet[header, 1])
    first_tile, end_tile = (width - int(sheet[header, 2])) // TILE, (int(sheet[header, 3]) + TILE - 1) // TILE
    sheet[header, 0] = sheet[header, 1] = sheet[header, 2] = sheet[header, 3] = NOTHING
    for row in range(first_row, end_row):
        sums, total = sheet[np.uint64(row)], NOTHING
        end = _list_touched(sums, np.uint64(width), np.uint64(first_tile), np.uint64(end_tile))
        for number in range(np.uint64(width + first_tile), end):
            total = sum_tile(sums, (int(sums[number]) - 1) << TILE_BITS, total, even_odd)
    return first_row, end_row, first_tile, end_tile


@kernel(inlined=True)
def _list_touched(sums: Rays, width: Any, first_tile: Any, end_tile: Any) -> Any:
    """Replace the flags of a row by the numbers of the tiles that hold anything, counted from 1; return their end.

    The loop has no branches: touched tiles cannot be predicted, and a wrong prediction costs as much as ten tiles.
    """
    place = width + first_tile
    for tile in range(first_tile, end_tile):
        is_touched = sums[width + tile] != NOTHING
        sums[width + tile] = NOTHING
        sums[place] = np.float32(tile + np.uint64(1))
        place += np.uint64(is_touched)
    if place < width + end_tile:
        sums[place] = NOTHING
    return place


@kernel(inlined=True)
def sum_tile(sums: Rays, first: int, total: Any, even_odd: bool) -> Any:
    """Turn a tile's changes of coverage into the signed winding number of the boundary around its pixels.

    Return the sum, from which the next tile continues. With the even-odd rule the coverage is written instead. Four
    pixels are summed at a time, so that only every fourth has to wait for the sum before it.
    """
    for quarter in range(TILE // 4):
        start = np.uint64(first) + np.uint64(4 * quarter)
        after, third, last = start + np.uint64(1), start + np.uint64(2), start + np.uint64(3)
        two = sums[start] + sums[after]
        three = two + sums[third]
        four = three + sums[last]
        sums[start] = total + sums[start]
        sums[after] = total + two
        sums[third] = total + three
        total += four
        sums[last] = total
    if even_odd:
        for place in range(first, first + TILE):
            size = abs(sums[place])
            rest = size - TWO * np.floor(size / TWO)
            sums[place] = TWO - rest if rest > ONE else rest
    return total


@kernel(inlined=True)
def fill_channels(line: Bytes, first: int, end: int, ink: Ink, share: Any) -> None:
    """Blend a colour into pixels of a row with one share."""
    colour, red, green, blue = ink
    if line.shape[1] != 3:
        for channel in range(line.shape[1]):
            value = np.int32(colour[channel] + 0.5) * np.int32(share) + 128
            for place in range(first, end):
                line[place, channel] = (np.int32(line[place, channel]) * np.int32(256 - share) + value) >> 8
        return
    # 255 * 256 + 128 fits into 16 bits.
    keep, part = np.uint16(256 - share), np.uint16(share)
    red, green, blue = np.uint16(red * part + MIDDLE), np.uint16(green * part + MIDDLE), np.uint16(blue * part + MIDDLE)
    for place in range(np.uint32(first), np.uint32(max(end, first))):  # unsigned: no index counts from the end
        line[place, 0] = np.uint16(np.uint16(line[place, 0]) * keep + red) >> 8
        line[place, 1] = np.uint16(np.uint16(line[place, 1]) * keep + green) >> 8
        line[place, 2] = np.uint16(np.uint16(line[place, 2]) * keep + blue) >> 8


@kernel(inlined=True)
def blend_channels(line: Bytes, first: int, end: int, ink: Ink, whole: Any, sums: Rays) -> None:
    """Blend a colour into pixels of a row, each by its coverage."""
    colour, red, green, blue = ink
    if line.shape[1] != 3:
        for place in range(first, end):
            share = np.int32(min(abs(sums[place]), ONE) * whole + HALF)
            for channel in range(line.shape[1]):
                value = np.int32(colour[channel] + 0.5) * share + 128
                line[place, channel] = (np.int32(line[place, channel]) * (256 - share) + value) >> 8
        return
    for place in range(np.uint32(first), np.uint32(max(end, first))):  # 16-bit lanes: twice as many at a time
        part = np.uint16(np.int32(min(abs(sums[place]), ONE) * whole + HALF))
        keep = np.uint16(np.uint16(256) - part)
        line[place, 0] = np.uint16(np.uint16(line[place, 0]) * keep + np.uint16(red * part + MIDDLE)) >> 8
        line[place, 1] = np.uint16(np.uint16(line[place, 1]) * keep + np.uint16(green * part + MIDDLE)) >> 8
        line[place, 2] = np.uint16(np.uint16(line[place, 2]) * keep + np.uint16(blue * part + MIDDLE)) >> 8
