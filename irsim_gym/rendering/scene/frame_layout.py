"""The layout of a frame: the mapping between pixels and points of the world."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import OptionError

DOTS_PER_INCH, POINTS_PER_INCH = 100.0, 72.0
BASE_SIDE = 506.0
LONGEST_SIDE = 1160.0
REFERENCE_SIDE = 600.0
PADDING = 9.0
LEFT, RIGHT, TOP, BOTTOM = 42.0, 34.0, 42.0, 34.0
BARE = 12.0
LOOSE = (0.125, 0.1, 0.12, 0.11)
"""Margins on the left, right, top and bottom, as shares of the frame, if the layout is not tight."""

Limits = tuple[float, float, float, float]
"""A rectangle of the world [m]: x_min, y_min, x_max, y_max."""


@dataclass(frozen=True)
class Layout:
    """The layout of a frame, in pixels from its lower left corner.

    Attributes:
        width: Width of the frame; even.
        height: Height of the frame; even.
        enlargement: Size of type and lines relative to a frame of 600 x 600.
        left: Left edge of the drawing area.
        bottom: Lower edge of the drawing area.
        plot_width: Width of the drawing area.
        plot_height: Height of the drawing area.
        scale: Pixels per metre.
        limits: The part of the world that the drawing area shows [m]: x_min, y_min, x_max, y_max.
        bounds: The world's rectangle [m], likewise.
    """

    width: int
    height: int
    enlargement: float
    left: int
    bottom: int
    plot_width: int
    plot_height: int
    scale: float
    limits: Limits
    bounds: Limits

    def column_row(self, x: float, y: float) -> tuple[float, float]:
        """Return column and row of the world point x, y [m] in a frame; rows count from the top."""
        column = self.left + (x - self.limits[0]) * self.scale
        row = self.height - (self.bottom + (y - self.limits[1]) * self.scale)
        return column, row

    def contains(self, x: float, y: float) -> bool:
        """Return whether the drawing area shows the world point x, y [m]."""
        x_min, y_min, x_max, y_max = self.limits
        return x_min <= x <= x_max and y_min <= y <= y_max

    def showing(self, limits: Limits) -> Layout:
        """Return the layout of a frame that shows another part of the world, as large as fits the drawing area.

        Args:
            limits: The part [m]: x_min, y_min, x_max, y_max; it is enlarged to the proportions of the drawing area.

        Raises:
            OptionError: If the limits are not finite or not increasing.
        """
        x_min, y_min, x_max, y_max = (float(value) for value in limits)
        if not (np.isfinite([x_min, y_min, x_max, y_max]).all() and x_min < x_max and y_min < y_max):
            expected = "x_min, y_min, x_max, y_max with x_min < x_max and y_min < y_max"
            raise OptionError("limits", f"the part of the world to look at must be {expected}, got {limits}")
        scale = min(self.plot_width / (x_max - x_min), self.plot_height / (y_max - y_min))
        half_x, half_y = 0.5 * self.plot_width / scale, 0.5 * self.plot_height / scale
        x, y = 0.5 * (x_min + x_max), 0.5 * (y_min + y_max)
        return replace(self, scale=scale, limits=(x - half_x, y - half_y, x + half_x, y + half_y))

    def centred(self, x: float, y: float) -> Layout:
        """Return a layout with the same scale and the point x, y [m] in the middle."""
        x_min, y_min, x_max, y_max = self.limits
        right, top = x - 0.5 * (x_min + x_max), y - 0.5 * (y_min + y_max)
        return replace(self, limits=(x_min + right, y_min + top, x_max + right, y_max + top))


def lay_out(
    bounds: Floats, size: tuple[int, int] | None = None, *, axis: bool = True, title: bool = True, tight: bool = True
) -> Layout:
    """Place a world rectangle on a frame.

    Args:
        bounds: The world's rectangle [m], x_min, y_min, x_max, y_max, shape ``(4,)``.
        size: Width and height of the frame in pixels, rounded to even numbers; None for a size by the proportions of
            the world, 600 x 600 for a square.
        axis: Whether to leave room for ticks.
        title: Whether to leave room for the status line.
        tight: Whether to leave no more room than that.
    """
    x_min, y_min, x_max, y_max = (float(value) for value in bounds)
    span_x, span_y = max(x_max - x_min, 1e-9), max(y_max - y_min, 1e-9)
    width, height = _natural_size(span_x, span_y, axis, title) if size is None else _even(size)
    if size is None and not tight:
        width, height = _even((width / (1.0 - LOOSE[0] - LOOSE[1]), height / (1.0 - LOOSE[2] - LOOSE[3])))
    enlargement = float(np.clip(np.sqrt(width * height) / REFERENCE_SIDE, 0.4, 4.0)) if size is not None else 1.0
    left, right, top, bottom = (enlargement * margin for margin in _margins(axis, title))
    if not tight:
        sides = zip((left, right, top, bottom), LOOSE, (width, width, height, height), strict=True)
        left, right, top, bottom = (max(margin, share * side) for margin, share, side in sides)
    room_x, room_y = max(width - left - right, 16.0), max(height - top - bottom, 16.0)
    padding = PADDING * enlargement
    scale = max(min((room_x - 2 * padding) / span_x, (room_y - 2 * padding) / span_y), 1e-9)
    plot_width = min(round(span_x * scale + 2 * padding), round(room_x))
    plot_height = min(round(span_y * scale + 2 * padding), round(room_y))
    # The drawing area is a whole number of pixels, so it shows a little more than the world, equally on both sides.
    margin_x = (plot_width / scale - span_x) / 2.0
    margin_y = (plot_height / scale - span_y) / 2.0
    return Layout(
        width=width,
        height=height,
        enlargement=enlargement,
        left=round(left + (room_x - plot_width) / 2.0),
        bottom=round(bottom + (room_y - plot_height) / 2.0),
        plot_width=plot_width,
        plot_height=plot_height,
        scale=scale,
        limits=(x_min - margin_x, y_min - margin_y, x_max + margin_x, y_max + margin_y),
        bounds=(x_min, y_min, x_max, y_max),
    )


def tick_positions(low: float, high: float, room: float) -> Floats:
    """Return round numbers between low and high [m], about one per 70 pixels of ``room`` at most, shape ``(n,)``."""
    if not low < high:
        return np.zeros(0)
    # The least round step (1, 2, 5 or 10 times a power of ten) that is not below the one wanted.
    spacing = (high - low) / max(min(room / 70.0, 12.0), 1.0)
    magnitude = 10.0 ** np.floor(np.log10(spacing))
    step = next(factor * magnitude for factor in (1.0, 2.0, 5.0, 10.0) if factor * magnitude >= spacing * (1 - 1e-9))
    first = np.ceil(low / step - 1e-9)
    last = np.floor(high / step + 1e-9)
    return np.asarray(np.arange(first, last + 1.0) * step, np.float64)


def _margins(axis: bool, title: bool) -> Limits:
    sides = (LEFT, RIGHT) if axis else (BARE, BARE)
    return *sides, (TOP if title else BARE), (BOTTOM if axis else BARE)


def _natural_size(span_x: float, span_y: float, axis: bool, title: bool) -> tuple[int, int]:
    """Return a frame size that gives all worlds a drawing area of equal area, unless they are very long."""
    left, right, top, bottom = _margins(axis, title)
    # Both sides multiply to BASE_SIDE^2, whatever the world's proportions are.
    side_x = BASE_SIDE * np.sqrt(span_x / span_y)
    side_y = BASE_SIDE * np.sqrt(span_y / span_x)
    shrink = min(1.0, LONGEST_SIDE / max(side_x, side_y))
    width, height = (max(side * shrink, 60.0) + 2.0 * PADDING for side in (side_x, side_y))
    return _even((width + left + right, height + top + bottom))


def _even(size: tuple[float, float]) -> tuple[int, int]:
    """Round to even numbers, which video formats require."""
    return max(2 * round(size[0] / 2.0), 2), max(2 * round(size[1] / 2.0), 2)
