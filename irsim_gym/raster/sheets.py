"""Exact coverage of pixels by areas, from the edges of these areas, and painting with it.

An area is drawn in two steps. Each edge of its boundary adds to a *sheet* by how much it changes the area to its right:
in each row the height that it crosses, shared between the pixel in which it crosses it and the next one. A sum along
the row is then how much of each pixel lies within the boundary, as often as the boundary winds around it.
``paint`` sums, blends a colour into the picture and leaves the sheet empty. (Signed areas are what FreeType and libart
sum; see R. Levien, "Inside the fastest font renderer in the world", 2016.)

A sheet is float32 and one row taller than its picture. Its first columns belong to pixels; those after them tell which
tiles of ``TILE`` columns hold anything, so that the inside of an area need not be summed. The last row says which rows
and columns were touched. ``new_sheet`` makes one; whoever draws at the same time as others has their own.

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
LEAST = np.float32(1.0 / 512.0)
"""Less coverage than this is not seen."""
NOTHING, HALF, ONE, TWO, WHOLE = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0), np.float32(256.0)
SLACK = 1e-6
"""More than abscissae along an edge are rounded by [pixel]."""


def new_sheet(height: int, width: int) -> Rays:
    """Return an empty sheet for pictures of this size [pixel]."""
    columns = max(width, 3) + 1
    return np.zeros((height + 1, columns + -(-columns // TILE)), np.float32)


@kernel
def add_edge(sheet: Rays, box: Ints, ax: float, ay: float, bx: float, by: float) -> None:
    """Add a directed edge from a to b [pixel] to a sheet; the edges of an area have to form closed ways.

    What lies left of the box counts as its left side does, what lies right of it, above it or below it not at all.
    """
    sign = 1.0
    if ay > by:
        ax, ay, bx, by, sign = bx, by, ax, ay, -1.0
    x_low, y_low, x_high, y_high = float(box[0]), float(box[1]), float(box[2]), float(box[3])
    if not (by > ay and by > y_low and ay < y_high and min(ax, bx) < x_high):
        return
    slope = (bx - ax) / (by - ay)
    from_y, to_y = max(ay, y_low), min(by, y_high)
    x, end_x = ax + slope * (from_y - ay), ax + slope * (to_y - ay)
    width = sheet.shape[1] * TILE // (TILE + 1)
    first, last = int(from_y), min(int(to_y), box[3] - 1)
    _note(sheet, width, first, last, max(min(x, end_x) - SLACK, x_low), max(min(max(x, end_x), x_high), x_low))
    for row in range(first, last + 1):
        tall = min(to_y, float(row + 1)) - max(from_y, float(row))
        if tall <= 0.0:
            continue
        next_x = end_x if row == last else x + slope * tall
        low, high = min(x, next_x), max(x, next_x)
        x = next_x
        column = int(max(low, x_low))
        if low >= x_low and high <= float(column + 1) and high < x_high:
            _deposit(sheet, width, row, column, sign * tall, 0.5 * (low + high) - float(column))
            continue
        per_column = sign * tall / max(high - low, 1e-300)
        if high <= x_low:
            _deposit(sheet, width, row, column, sign * tall, 0.0)
        elif low < x_low:
            _deposit(sheet, width, row, column, per_column * (x_low - low), 0.0)
        place, high = max(low, x_low), min(high, x_high)
        while place < high:
            until = min(float(column + 1), high)
            _deposit(sheet, width, row, column, per_column * (until - place), 0.5 * (place + until) - float(column))
            place = until
            column += 1


@kernel(inlined=True)
def _deposit(sheet: Rays, width: int, row: int, column: int, height: float, share: float) -> None:
    """Add the height that an edge crosses within a pixel, on average ``share`` of its width from its left side."""
    sheet[row, width + column // TILE] = ONE
    sheet[row, column] += np.float32(height * (1.0 - share))
    sheet[row, width + (column + 1) // TILE] = ONE
    sheet[row, column + 1] += np.float32(height * share)


@kernel(inlined=True)
def _note(sheet: Rays, width: int, first: int, last: int, low: float, high: float) -> None:
    """Note the rows and columns that an edge touches; zeros mean that nothing was touched."""
    header = sheet.shape[0] - 1
    sheet[header, 0] = max(sheet[header, 0], np.float32(header - first))
    sheet[header, 1] = max(sheet[header, 1], np.float32(last + 1))
    sheet[header, 2] = max(sheet[header, 2], np.float32(width - int(low)))
    sheet[header, 3] = max(sheet[header, 3], np.float32(min(int(high) + 2, width)))


@kernel
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
    first, end = width - int(sheet[header, 2]), min(int(sheet[header, 3]), width)
    sheet[header, 0] = sheet[header, 1] = sheet[header, 2] = sheet[header, 3] = NOTHING
    opacity = np.float32(min(max(float(colour[picture.shape[2]]), 0.0), 1.0))
    for row in range(first_row, end_row):
        total, tile = NOTHING, first // TILE
        while tile * TILE < end:
            column = tile * TILE
            if sheet[row, width + tile] != NOTHING:
                sheet[row, width + tile] = NOTHING
                until = min(column + TILE, width)
                for place in range(column, until):
                    total += sheet[row, place]
                    sheet[row, place] = NOTHING
                    covered = _covered(total, even_odd)
                    if covered > LEAST and place < box[2]:
                        _blend(picture, row, place, place + 1, colour, covered * opacity)
                tile += 1
                continue
            while tile * TILE < end and sheet[row, width + tile] == NOTHING:
                tile += 1
            covered = _covered(total, even_odd)
            if covered > LEAST:
                _blend(picture, row, column, min(tile * TILE, box[2]), colour, covered * opacity)
        covered = _covered(total, even_odd)
        if covered > LEAST:
            _blend(picture, row, tile * TILE, box[2], colour, covered * opacity)


@kernel(inlined=True)
def _covered(winding: Any, even_odd: bool) -> Any:
    """Return how much of a pixel is covered, from how much of it the boundary winds around, counted with sign."""
    size = abs(winding)
    if not even_odd:
        return min(size, ONE)
    rest = size - TWO * np.floor(size / TWO)
    return TWO - rest if rest > ONE else rest


@kernel(inlined=True)
def _blend(picture: Bytes, row: int, first: int, end: int, colour: Floats, opacity: Any) -> None:
    """Blend a colour into the pixels of a row from ``first`` to ``end``."""
    share = np.int32(opacity * WHOLE + HALF)
    keep, line = np.int32(256) - share, picture[row]
    if picture.shape[2] == 4:
        _blend_four(line, first, end, colour, share, keep)
        return
    if picture.shape[2] != 3:
        for channel in range(picture.shape[2]):
            value = np.int32(colour[channel] + 0.5) * share + 128
            for column in range(first, end):
                line[column, channel] = (np.int32(line[column, channel]) * keep + value) >> 8
        return
    red = np.int32(colour[0] + 0.5) * share + 128
    green = np.int32(colour[1] + 0.5) * share + 128
    blue = np.int32(colour[2] + 0.5) * share + 128
    for column in range(np.uint32(first), np.uint32(end)):  # unsigned: no index counts from the end, and lanes are used
        line[column, 0] = (np.int32(line[column, 0]) * keep + red) >> 8
        line[column, 1] = (np.int32(line[column, 1]) * keep + green) >> 8
        line[column, 2] = (np.int32(line[column, 2]) * keep + blue) >> 8


@kernel(inlined=True)
def _blend_four(line: Bytes, first: int, end: int, colour: Floats, share: Any, keep: Any) -> None:
    """Blend a colour into pixels with four channels, in lanes."""
    red = np.int32(colour[0] + 0.5) * share + 128
    green = np.int32(colour[1] + 0.5) * share + 128
    blue = np.int32(colour[2] + 0.5) * share + 128
    fourth = np.int32(colour[3] + 0.5) * share + 128
    for column in range(np.uint32(first), np.uint32(end)):
        line[column, 0] = (np.int32(line[column, 0]) * keep + red) >> 8
        line[column, 1] = (np.int32(line[column, 1]) * keep + green) >> 8
        line[column, 2] = (np.int32(line[column, 2]) * keep + blue) >> 8
        line[column, 3] = (np.int32(line[column, 3]) * keep + fourth) >> 8
