"""The density of obstacles over the levels of an evaluation."""

from collections.abc import Iterable

import numpy as np
from PIL import Image, ImageDraw

from irsim_gym.base.arraytypes import Bytes, Floats
from irsim_gym.rendering.scene.scene import DrawnBody, MapView

CELLS = 240
"""Cells along the longer side of the world."""
FINER = 2


class Density:
    """The share of levels in which each place is occupied.

    Args:
        bounds: The world's rectangle [m]: x_min, y_min, x_max, y_max, ``(4,)``.

    Attributes:
        differs: Whether obstacles differ between levels.
    """

    def __init__(self, bounds: Floats) -> None:
        self.bounds = tuple(float(value) for value in bounds)
        x_min, y_min, x_max, y_max = self.bounds
        self._scale = FINER * CELLS / max(x_max - x_min, y_max - y_min)
        self._size = max(round((x_max - x_min) * self._scale), 1), max(round((y_max - y_min) * self._scale), 1)
        self._sum: Floats = np.zeros(self._size[::-1])
        self._levels = 0
        self._first: Bytes = np.zeros(0, np.uint8)
        self.differs = False

    def add(self, bodies: Iterable[DrawnBody], occupied: MapView | None = None) -> None:
        """Add the obstacles of a level."""
        picture = Image.new("L", self._size)
        draw = ImageDraw.Draw(picture)
        for body in bodies:
            for line in body.lines:
                if body.solid:
                    draw.polygon(self._pixels(line), fill=1)
                else:
                    draw.line(self._pixels(line), fill=1, width=FINER)
            for x, y, radius in body.discs.tolist():
                (column, row), reach = self._pixels(np.array([[x, y]]))[0], radius * self._scale
                draw.ellipse((column - reach, row - reach, column + reach, row + reach), fill=1)
        if occupied is not None:
            self._draw_map(draw, occupied)
        seen = np.asarray(picture)
        if not self._levels:
            self._first = seen.copy()
        self.differs |= not np.array_equal(seen, self._first)
        self._sum += seen
        self._levels += 1

    def shares(self) -> Floats:
        """Return the shares, row 0 at the top, shape ``(n_rows, n_columns)``."""
        rows, columns = (length // FINER for length in self._sum.shape)
        # Each cell is the mean of FINER x FINER pixels, so that edges are smooth.
        cut = self._sum[: rows * FINER, : columns * FINER].reshape(rows, FINER, columns, FINER).mean(axis=(1, 3))
        return np.asarray(cut / max(self._levels, 1))

    def _pixels(self, points: Floats) -> list[tuple[float, float]]:
        columns = (points[:, 0] - self.bounds[0]) * self._scale
        rows = (self.bounds[3] - points[:, 1]) * self._scale
        return list(zip(columns.tolist(), rows.tolist(), strict=True))

    def _draw_map(self, draw: ImageDraw.ImageDraw, view: MapView) -> None:
        x_min, y_min, x_max, y_max = view.extent
        wide, high = (x_max - x_min) / view.occupied.shape[0], (y_max - y_min) / view.occupied.shape[1]
        for column, row in np.argwhere(view.occupied).tolist():
            low = x_min + column * wide, y_min + row * high
            (left, bottom), (right, top) = self._pixels(np.array([low, (low[0] + wide, low[1] + high)]))
            draw.rectangle((left, top, right, bottom), fill=1)
