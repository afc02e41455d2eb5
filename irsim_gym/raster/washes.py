"""Many areas and lines at once, for canvases of other libraries whose blending is slow.

Such a canvas has four bytes for each pixel, which are blended as one word: two channels at a time, with a free byte
between them for what a product carries over. The results are those of ``sheets.paint``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import Floats, Ints, Pixels, Rays
from irsim_gym.jit import kernel
from irsim_gym.raster.areas import add_line, add_polygon, is_near
from irsim_gym.raster.sheets import HALF, ONE, cover

EVEN, ODD, ROUND, OPAQUE = (np.uint32(word) for word in (0x00FF00FF, 0xFF00FF00, 0x00800080, 0xFF000000))
BYTE, SEVEN, WHOLE_SHARE = np.uint32(8), np.uint32(7), np.uint32(256)
STRAIGHT = 1e-4
"""Edges that are nearer than this to a row or a column lie along it [pixel]."""


@kernel
def wash_areas(
    picture: Pixels,
    sheet: Rays,
    box: Ints,
    starts: Ints,
    fills: Floats,
    edges: Floats,
    widths: Floats,
    points: Floats,
) -> None:
    """Paint polygons, one after another, each with its edge; see ``sheets`` for sheet, box and colours.

    Args:
        picture: Four bytes a pixel, shape ``(height, width)``.
        sheet: An empty sheet, left empty.
        box: Part of the picture that may change.
        starts: First corner of each, and the number of all, shape ``(n + 1,)``.
        fills: Their colours, each as a word and an opacity, shape ``(n, 2)``.
        edges: Colours of their edges, likewise.
        widths: Widths of their edges [pixel]; 0 for none, shape ``(n,)``.
        points: Corners of all [pixel], shape ``(n_points, 2)``; those of boxes along rows and columns are moved to
            where their edges are sharp.
    """
    for k in range(starts.shape[0] - 1):
        first, count = starts[k], starts[k + 1] - starts[k]
        has_edge = widths[k] > 0.0 and edges[k, 1] > 0.0
        sharpen(first, count, widths[k], True, points)
        if fills[k, 1] > 0.0:
            add_polygon(sheet, box, points, first, count)
            wash(picture, sheet, box, fills[k])
        if has_edge:
            add_line(sheet, box, points, first, count, widths[k], True, True)
            wash(picture, sheet, box, edges[k])


@kernel
def wash_lines(
    picture: Pixels,
    sheet: Rays,
    box: Ints,
    bundles: Ints,
    starts: Ints,
    colours: Floats,
    width: float,
    points: Floats,
) -> None:
    """Paint bundles of lines with cut ends; within a bundle they are not darker where they overlap.

    Args:
        picture: Four bytes a pixel, shape ``(height, width)``.
        sheet: An empty sheet, left empty.
        box: Part of the picture that may change.
        bundles: First line of each bundle, and the number of all lines, shape ``(n_bundles + 1,)``.
        starts: First point of each line, and the number of all points, shape ``(n_lines + 1,)``.
        colours: Colours of the bundles, each as a word and an opacity, shape ``(n_bundles, 2)``.
        width: Width of the lines [pixel].
        points: Points of all lines [pixel], shape ``(n_points, 2)``; those of lines along rows and columns are moved to
            where they are sharp.
    """
    for k in range(bundles.shape[0] - 1):
        for i in range(bundles[k], bundles[k + 1]):
            first, count = starts[i], starts[i + 1] - starts[i]
            sharpen(first, count, width, False, points)
            add_line(sheet, box, points, first, count, width, False, False)
        wash(picture, sheet, box, colours[k])


@kernel(inlined=True)
def wash(picture: Pixels, sheet: Rays, box: Ints, colour: Floats) -> None:
    """Blend a colour (a word, an opacity) into a picture where a sheet's areas are, and leave the sheet empty.

    As ``sheets.paint`` does for pictures of single bytes.
    """
    cover(picture, sheet, box, False, float(colour[1]), np.uint32(colour[0]), blend_words, fill_words)


@kernel(inlined=True)
def fill_words(line: Pixels, first: int, end: int, ink: Any, share: Any) -> None:
    """Blend a colour into the pixels of a row."""
    part = np.uint32(share)
    for place in range(np.uint32(first), np.uint32(max(end, first))):
        line[place] = blended(line[place], ink, part)


@kernel(inlined=True)
def blend_words(line: Pixels, first: int, end: int, ink: Any, whole: Any, sums: Rays) -> None:
    """Blend a colour into the pixels of a row, each as far as it lies within the boundary."""
    for place in range(np.uint32(first), np.uint32(max(end, first))):
        share = np.uint32(min(abs(sums[place]), ONE) * whole + HALF)
        line[place] = blended(line[place], ink, share)


@kernel(inlined=True)
def blended(pixel: Any, ink: Any, share: Any) -> Any:
    """Return a pixel with ``share`` of 256 parts of a colour blended into its four bytes."""
    keep = WHOLE_SHARE - share
    low = (pixel & EVEN) * keep + (ink & EVEN) * share + ROUND
    high = ((pixel >> BYTE) & EVEN) * keep + ((ink >> BYTE) & EVEN) * share + ROUND
    return np.uint32(((low >> BYTE) & EVEN) | (high & ODD))


@kernel
def stamp(picture: Pixels, box: Ints, strip: Pixels, column: int, row: int) -> None:
    """Put pixels with opacities onto a picture.

    Args:
        picture: Four bytes a pixel, shape ``(height, width)``.
        box: Part of the picture that may change.
        strip: Colours and, as fourth byte in memory, opacity, its lowest row first, shape ``(n_rows, n_columns)``.
        column: Column of its left edge.
        row: Row of its lowest one, from above.
    """
    shift = np.uint32(24)
    for k in range(max(row + 1 - box[3], 0), min(row + 1 - box[1], strip.shape[0])):
        line, given = picture[np.uint64(row - k)], strip[np.uint64(k)]
        for i in range(max(box[0] - column, 0), min(box[2] - column, strip.shape[1])):
            opacity = given[np.uint64(i)] >> shift
            if opacity > 0:
                place = np.uint64(column + i)
                line[place] = blended(line[place], given[np.uint64(i)] | OPAQUE, opacity + (opacity >> SEVEN))


@kernel
def sharpen(first: int, count: int, width: float, closed: bool, points: Floats) -> None:
    """Move points of a way that goes only along rows and columns, as Agg does, so that a line's sides are sharp.

    Args:
        first: The first of its points.
        count: Number of its points.
        width: Width of the line [pixel].
        closed: It goes back to its first point.
        points: Points of all ways [pixel], shape ``(n_points, 2)``.
    """
    if not is_near(points, first, count):
        return
    for i in range(first if closed else first + 1, first + count):
        before = i - 1 if i > first else first + count - 1
        dx, dy = abs(points[i, 0] - points[before, 0]), abs(points[i, 1] - points[before, 1])
        if dx >= STRAIGHT and dy >= STRAIGHT:
            return
    middle = 0.5 if int(width + 0.5) % 2 == 1 else 0.0
    for i in range(first, first + count):
        points[i, 0] = np.floor(points[i, 0] + 0.5) + middle
        points[i, 1] = np.floor(points[i, 1] + 0.5) + middle
