"""Exact coverage of pixels by areas, from the edges of these areas, and painting with it.

An area is drawn in two steps. Each edge of its boundary adds to a *sheet* by how much it changes the area to its right:
in each row the height that it crosses, shared between the pixel in which it crosses it and the next one. A sum along
the row is then how much of each pixel lies within the boundary, as often as the boundary winds around it.
``paint`` sums, blends a colour into the picture and leaves the sheet empty. (Signed areas are what FreeType and libart
sum; see R. Levien, "Inside the fastest font renderer in the world", 2016.)

A sheet is float32 and one row taller than its picture. Its first columns belong to pixels; those after them tell which
tiles of ``TILE`` columns hold anything, so that the inside of an area need not be summed. The last row, the header,
says which rows and columns were touched, in ``HEADER`` numbers, and has room for a list of a row's tiles. ``new_sheet``
makes one; whoever draws at the same time as others has their own.

Places are pixels from the upper left corner of the picture, x to the right and y down; the middle of the first pixel is
0.5, 0.5. A *box* is int64 ``(4,)``: first column, first row, end column, end row, all within the picture; nothing
outside is painted. A *colour* is float64 ``(n_channels + 1,)``: the channels' values [0, 255], then an opacity [0, 1].
"""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import Bytes, Floats, Ints, Rays
from irsim_gym.jit import kernel

TILE = 16
HEADER = 4
FARTHEST = 1e9
Ink = tuple[Any, Any, Any]
NOTHING, HALF, ONE, TWO, WHOLE = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0), np.float32(256.0)


def new_sheet(height: int, width: int) -> Rays:
    """Return an empty sheet for pictures of this size [pixel]."""
    tiles = width // TILE + 1
    return np.zeros((height + 1, tiles * (TILE + 1)), np.float32)


@kernel
def add_edge(sheet: Rays, box: Ints, ax: float, ay: float, bx: float, by: float) -> None:
    """Add a directed edge from a to b [pixel] to a sheet; the edges of an area have to form closed ways.

    What lies left of the box counts as its left side does, what lies right of it, above it or below it not at all.
    """
    note(sheet, box, min(ax, bx), min(ay, by), max(ax, bx), max(ay, by))
    scan_edge(sheet, box, ax, ay, bx, by)


@kernel
def note(sheet: Rays, box: Ints, left: float, top: float, right: float, foot: float) -> None:
    """Note where edges are going to be added: within these sides [pixel], which may be wider than need be."""
    header, width = sheet.shape[0] - 1, sheet.shape[1] * TILE // (TILE + 1)
    if not (left < box[2] and foot > box[1] and top < box[3]):
        return
    first_row, end_row = max(int(max(top, 0.0)), box[1]), min(int(min(foot, float(box[3]))) + 1, box[3])
    first, end = max(int(max(left, 0.0)), box[0]), min(int(min(max(right, float(box[0])), float(box[2]))) + 2, width)
    sheet[header, 0] = max(sheet[header, 0], np.float32(header - first_row))
    sheet[header, 1] = max(sheet[header, 1], np.float32(end_row))
    sheet[header, 2] = max(sheet[header, 2], np.float32(width - first))
    sheet[header, 3] = max(sheet[header, 3], np.float32(end))


@kernel(inlined=True)
def scan_edge(sheet: Rays, box: Ints, ax: float, ay: float, bx: float, by: float) -> None:
    """Add an edge whose place was noted; see ``add_edge``."""
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
    """Add the part of an edge that lies within a row; ``height`` is how much of the row it crosses, with its sign."""
    low, high = min(x, end_x), max(x, end_x)
    column = int(max(low, x_low))
    if low >= x_low and high <= float(column + 1) and high < x_high:
        _deposit(sheet, width, row, column, height, 0.5 * (low + high) - float(column))
        return
    if high <= x_low:
        _deposit(sheet, width, row, column, height, 0.0)
        return
    per_column = height / (high - low) if high > low else 0.0
    line, carried = sheet[np.uint64(row)], 0.0
    first, place, high = column, max(low, x_low), min(high, x_high)
    if not place < high:
        return
    if low < x_low:
        line[np.uint64(column)] += np.float32(per_column * (x_low - low))
    while place < high:
        until = min(float(column + 1), high)
        part = per_column * (until - place)
        right = part * (0.5 * (place + until) - float(column))
        line[np.uint64(column)] += np.float32(carried + part - right)
        place, carried, column = until, right, column + 1
    line[np.uint64(column)] += np.float32(carried)
    for tile in range(first // TILE, column // TILE + 1):
        line[np.uint64(width + tile)] = ONE


@kernel(inlined=True)
def _deposit(sheet: Rays, width: int, row: int, column: int, height: float, share: float) -> None:
    """Add the height that an edge crosses within a pixel, on average ``share`` of its width from its left side."""
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
        box: Which part of the picture may change.
        colour: Colour and opacity.
        even_odd: A place lies within an area if the boundary winds around it an odd number of times; else if it
            does not wind around it zero times.
    """
    header, width = sheet.shape[0] - 1, sheet.shape[1] * TILE // (TILE + 1)
    first_row, end_row = header - int(sheet[header, 0]), int(sheet[header, 1])
    first_tile, end_tile = (width - int(sheet[header, 2])) // TILE, (int(sheet[header, 3]) + TILE - 1) // TILE
    sheet[header, 0] = sheet[header, 1] = sheet[header, 2] = sheet[header, 3] = NOTHING
    whole = WHOLE * np.float32(min(max(float(colour[picture.shape[2]]), 0.0), 1.0))
    last = picture.shape[2]  # a channel that there is not has any value
    ink = np.uint16(colour[0] + 0.5), np.uint16(colour[min(1, last)] + 0.5), np.uint16(colour[min(2, last)] + 0.5)
    for row in range(first_row, end_row):
        share, sums, painted, total = np.int32(0), sheet[row], box[2], NOTHING
        end = _list_touched(sums, sheet[header], width, first_tile, end_tile)
        for number in range(HEADER, end):
            total = sum_tile(sums, int(sheet[header, number]) * TILE, total, even_odd)
        for number in range(HEADER, end):  # once the sums of the row are written, they are read many at a time
            column = int(sheet[header, number]) * TILE
            if share > 0 and painted < column:
                _blend(picture, row, painted, min(column, box[2]), colour, ink, share)
            painted = column + TILE
            _blend_sums(picture, row, column, min(painted, box[2]), colour, ink, whole, sums)
            share = np.int32(min(abs(sums[painted - 1]), ONE) * whole + HALF)
            for place in range(TILE):
                sums[np.uint64(column) + np.uint64(place)] = NOTHING
        if share > 0:
            _blend(picture, row, painted, box[2], colour, ink, share)
    for number in range(HEADER, HEADER + end_tile - first_tile):
        sheet[header, number] = NOTHING


@kernel(inlined=True)
def _list_touched(sums: Rays, touched: Rays, width: int, first_tile: int, end_tile: int) -> Any:
    """Write which tiles of a row hold anything behind the header's numbers; return where the list ends.

    It branches nowhere: which tile holds something cannot be foretold, and a wrong guess costs as much as ten tiles.
    """
    count = np.uint64(HEADER)
    for tile in range(np.uint64(first_tile), np.uint64(end_tile)):
        flag = np.uint64(width) + tile
        touched[count] = np.float32(tile)
        count += np.uint64(sums[flag] != NOTHING)
        sums[flag] = NOTHING
    return np.int64(count)


@kernel(inlined=True)
def sum_tile(sums: Rays, first: int, total: Any, even_odd: bool) -> Any:
    """Turn a tile's changes of coverage into how often the boundary winds around its pixels, counted with sign.

    The sum goes on to the next tile: it is returned. With the even-odd rule what is written is how much is covered.
    Four are summed at a time, so that only every fourth has to wait for the sum of those before.
    """
    for quarter in range(TILE // 4):
        one = np.uint64(first) + np.uint64(4 * quarter)
        after, third, last = one + np.uint64(1), one + np.uint64(2), one + np.uint64(3)
        two = sums[one] + sums[after]
        three = two + sums[third]
        four = three + sums[last]
        sums[one] = total + sums[one]
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
def _blend(picture: Bytes, row: int, first: int, end: int, colour: Floats, ink: Ink, share: Any) -> None:
    """Blend ``share`` of 256 parts of a colour into the pixels of a row from ``first`` to ``end``."""
    keep, line, part = np.uint16(256 - share), picture[np.uint64(row)], np.uint16(share)
    if picture.shape[2] != 3:
        for channel in range(picture.shape[2]):
            value = np.int32(colour[channel] + 0.5) * np.int32(share) + 128
            for column in range(first, end):
                line[column, channel] = (np.int32(line[column, channel]) * np.int32(keep) + value) >> 8
        return
    half = np.uint16(128)
    red, green, blue = (
        np.uint16(ink[0] * part + half),
        np.uint16(ink[1] * part + half),
        np.uint16(ink[2] * part + half),
    )
    for column in range(np.uint32(first), np.uint32(end)):  # unsigned: no index counts from the end; lanes are used
        line[column, 0] = np.uint16(np.uint16(line[column, 0]) * keep + red) >> 8
        line[column, 1] = np.uint16(np.uint16(line[column, 1]) * keep + green) >> 8
        line[column, 2] = np.uint16(np.uint16(line[column, 2]) * keep + blue) >> 8


@kernel(inlined=True)
def _blend_sums(
    picture: Bytes, row: int, first: int, end: int, colour: Floats, ink: Ink, whole: Any, sums: Rays
) -> None:
    """Blend a colour into the pixels of a row from ``first`` to ``end``, each as far as it lies within the boundary."""
    line, half = picture[np.uint64(row)], np.uint16(128)
    if picture.shape[2] != 3:
        for column in range(first, end):
            part = np.int32(min(abs(sums[column]), ONE) * whole + HALF)
            for channel in range(picture.shape[2]):
                value = np.int32(colour[channel] + 0.5) * part + 128
                line[column, channel] = (np.int32(line[column, channel]) * (256 - part) + value) >> 8
        return
    for column in range(np.uint32(first), np.uint32(end)):
        share = np.uint16(np.int32(min(abs(sums[column]), ONE) * whole + HALF))
        keep = np.uint16(np.uint16(256) - share)
        line[column, 0] = np.uint16(np.uint16(line[column, 0]) * keep + np.uint16(ink[0] * share + half)) >> 8
        line[column, 1] = np.uint16(np.uint16(line[column, 1]) * keep + np.uint16(ink[1] * share + half)) >> 8
        line[column, 2] = np.uint16(np.uint16(line[column, 2]) * keep + np.uint16(ink[2] * share + half)) >> 8
