"""Paints translucent areas on a canvas of matplotlib's with kernels of our own.

Agg takes 5 ns to blend a colour into one pixel of a canvas that has an opacity; the kernels take a fifth of that.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.transforms import Affine2D, BboxBase

from irsim_gym.arraytypes import Bytes, Floats, Ints, Pixels
from irsim_gym.raster.sheets import new_sheet
from irsim_gym.raster.washes import stamp, wash_areas, wash_lines

Colour = tuple[float, float, float, float]


class Washer:
    """A canvas of pixels.

    Args:
        renderer: An Agg renderer, whose pixels are painted.
        to_canvas: From metres to its pixels, upwards.
    """

    def __init__(self, renderer: Any, to_canvas: Affine2D) -> None:
        self._picture: Pixels = np.asarray(renderer.buffer_rgba()).view(np.uint32)[..., 0]
        height, width = self._picture.shape[:2]
        self._sheet = new_sheet(height, width)
        (across, _, x), (_, up, y), _ = to_canvas.get_matrix().tolist()
        self._scale, self._shift = np.array([across, -up]), np.array([x, height - y])
        self._size = width, height
        self._cuts: dict[int, tuple[BboxBase, Ints]] = {}

    def areas(
        self,
        box: BboxBase,
        ways: Sequence[Floats],
        fills: Sequence[Colour],
        edges: Sequence[Colour],
        widths: Sequence[float],
    ) -> None:
        """Paint polygons.

        Args:
            box: Where on the canvas.
            ways: Corners of each [m], shape ``(n, 2)``.
            fills: Their colours.
            edges: Colours of their edges.
            widths: Widths of their edges [pixel]; 0 for none.
        """
        points, starts = self._packed(ways)
        fill, edge, wide = _paints(tuple(fills)), _paints(tuple(edges)), np.array(widths, np.float64)
        wash_areas(self._picture, self._sheet, self._cut(box), starts, fill, edge, wide, points)

    def lines(
        self, box: BboxBase, bundles: Sequence[Sequence[Floats]], colours: Sequence[Colour], width: float
    ) -> None:
        """Paint bundles of lines.

        Args:
            box: Where on the canvas.
            bundles: The points of each of their lines [m], shape ``(n, 2)``.
            colours: Their colours.
            width: Width of the lines [pixel].
        """
        points, starts = self._packed([way for ways in bundles for way in ways])
        counts = np.cumsum([0, *(len(ways) for ways in bundles)])
        wash_lines(
            self._picture, self._sheet, self._cut(box), counts, starts, _paints(tuple(colours)), float(width), points
        )

    def strip(self, box: BboxBase, pixels: Bytes, column: int, row: int) -> None:
        """Put pixels with opacities on the canvas.

        Args:
            box: Where on the canvas.
            pixels: Colours and opacities, the lowest row first, shape ``(height, width, 4)``.
            column: Where their left edge is.
            row: Where their lower edge is, from below.
        """
        stamp(self._picture, self._cut(box), pixels.view(np.uint32)[..., 0], column, self._size[1] - 1 - row)

    def _packed(self, ways: Sequence[Floats]) -> tuple[Floats, Ints]:
        starts = np.zeros(len(ways) + 1, np.int64)
        np.cumsum([len(way) for way in ways], out=starts[1:])
        points = np.concatenate(ways)
        points *= self._scale
        points += self._shift
        return points, starts

    def _cut(self, box: BboxBase) -> Ints:
        """Return a box as the kernels want it: first column and row from above, end column and row."""
        known = self._cuts.get(id(box))
        if known is None or known[0] is not box:
            known = self._cuts[id(box)] = box, self._cut_of(box)
        return known[1]

    def _cut_of(self, box: BboxBase) -> Ints:
        width, height = self._size
        # Where nothing of the world is in view the box lies outside.
        left, low, right, high = (round(value) for value in np.clip(box.extents, -1.0, width + height).tolist())
        first = min(max(left, 0), width), min(max(height - high, 0), height)
        box_of = *first, max(min(right, width), first[0]), max(min(height - low, height), first[1])
        return np.array(box_of, np.int64)


@functools.lru_cache(maxsize=1024)
def _paints(colours: tuple[Colour, ...]) -> Floats:
    """Return colours as the kernels want them on an opaque canvas with four channels, shape ``(n, 2)``; to be read."""
    given = np.array(colours, np.float64).reshape(len(colours), 4)
    inks = np.full((len(colours), 4), 255, np.uint8)
    inks[:, :3] = 255.0 * given[:, :3] + 0.5
    return np.column_stack([inks.view(np.uint32)[:, 0].astype(np.float64), given[:, 3]])
