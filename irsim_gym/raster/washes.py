"""Many areas and lines at once, for canvases of other libraries whose blending is slow."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Bytes, Floats, Ints, Rays
from irsim_gym.jit import kernel
from irsim_gym.raster.areas import add_line, add_polygon, is_near
from irsim_gym.raster.sheets import paint

STRAIGHT = 1e-4
"""Edges that are nearer than this to a row or a column lie along it [pixel]."""


@kernel
def wash_areas(
    picture: Bytes,
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
        picture: uint8, shape ``(height, width, n_channels)``.
        sheet: An empty sheet, left empty.
        box: Part of the picture that may change.
        starts: First corner of each, and the number of all, shape ``(n + 1,)``.
        fills: Their colours, shape ``(n, n_channels + 1)``.
        edges: Colours of their edges, likewise.
        widths: Widths of their edges [pixel]; 0 for none, shape ``(n,)``.
        points: Corners of all [pixel], shape ``(n_points, 2)``; those of boxes along rows and columns are moved to
            where their edges are sharp.
    """
    opacity = picture.shape[2]
    for k in range(starts.shape[0] - 1):
        first, count = starts[k], starts[k + 1] - starts[k]
        has_edge = widths[k] > 0.0 and edges[k, opacity] > 0.0
        sharpen(first, count, widths[k], True, points)
        if fills[k, opacity] > 0.0:
            add_polygon(sheet, box, points, first, count)
            paint(picture, sheet, box, fills[k], False)
        if has_edge:
            add_line(sheet, box, points, first, count, widths[k], True, True)
            paint(picture, sheet, box, edges[k], False)


@kernel
def wash_lines(
    picture: Bytes,
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
        picture: uint8, shape ``(height, width, n_channels)``.
        sheet: An empty sheet, left empty.
        box: Part of the picture that may change.
        bundles: First line of each bundle, and the number of all lines, shape ``(n_bundles + 1,)``.
        starts: First point of each line, and the number of all points, shape ``(n_lines + 1,)``.
        colours: Colours of the bundles, shape ``(n_bundles, n_channels + 1)``.
        width: Width of the lines [pixel].
        points: Points of all lines [pixel], shape ``(n_points, 2)``; those of lines along rows and columns are moved to
            where they are sharp.
    """
    for k in range(bundles.shape[0] - 1):
        for i in range(bundles[k], bundles[k + 1]):
            first, count = starts[i], starts[i + 1] - starts[i]
            sharpen(first, count, width, False, points)
            add_line(sheet, box, points, first, count, width, False, False)
        paint(picture, sheet, box, colours[k], False)


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
