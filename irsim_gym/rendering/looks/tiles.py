"""Arranges several pictures in a grid."""

import math
from collections.abc import Sequence

import numpy as np

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering.looks import theme

SCREEN = (1280, 760)
"""Width and height for all tiles together, so that they fit on a screen [pixel]."""
SMALLEST_TILE = 96


def grid(frames: Sequence[Bytes], columns: int | None = None) -> Bytes:
    """Arrange frames in rows of ``columns`` frames; None for up to four.

    Args:
        frames: Frames, uint8, shape ``(height, width, 3)``; smaller ones are placed at the top left of their cell.
        columns: Frames per row.
    """
    columns = min(columns or few_columns(len(frames)), len(frames))
    rows = math.ceil(len(frames) / columns)
    height, width = (max(frame.shape[axis] for frame in frames) for axis in (0, 1))
    picture = np.empty((rows * height, columns * width, 3), np.uint8)
    if len(frames) < rows * columns or any(frame.shape[:2] != (height, width) for frame in frames):
        for channel in range(3):  # ten times as fast as one assignment
            picture[..., channel] = int(theme.PAPER[1 + 2 * channel : 3 + 2 * channel], 16)
    for k, frame in enumerate(frames):
        row, column = divmod(k, columns)
        top, left = row * height, column * width
        picture[top : top + frame.shape[0], left : left + frame.shape[1]] = frame
    return picture


def few_columns(count: int) -> int:
    """Return a number of columns that fills the rows evenly: at most four, but two for four pictures."""
    return count if count <= 3 else math.ceil(count / math.ceil(count / 4)) if count != 4 else 2


def fitting(
    count: int, size: tuple[int, int], columns: int | None = None, room: tuple[int, int] = SCREEN
) -> tuple[int, tuple[int, int]]:
    """Return the number of columns and the size with which pictures fit best into a rectangle.

    Args:
        count: Number of pictures, at least one.
        size: Width and height of a picture [pixel]; pictures are never enlarged.
        columns: A fixed number of columns; None for the one that shows the pictures large and leaves few cells empty.
        room: Width and height of the rectangle [pixel].

    Returns:
        Number of columns, and width and height of each picture [pixel]: even, and at least ``SMALLEST_TILE`` unless
        ``size`` is smaller, even if that exceeds the room.
    """
    width, height = size

    def share(n: int) -> float:
        return min(1.0, room[0] / (n * width), room[1] / (math.ceil(count / n) * height))

    def quality(n: int) -> tuple[float, float]:
        rows = math.ceil(count / n)
        # First the size of pictures, times the share of cells in use; among equals, proportions near the room's.
        proportions = n * width / (rows * height) / (room[0] / room[1])
        return round(share(n) * count / (n * rows), 6), -abs(math.log(proportions))

    candidates = range(1, count + 1) if columns is None else [max(1, min(columns, count))]
    best = max(candidates, key=quality)
    least = min(1.0, SMALLEST_TILE / min(width, height))
    chosen = max(share(best), least)
    return best, (_even(chosen * width), _even(chosen * height))


def _even(length: float) -> int:
    return max(2 * int(length / 2.0), 2)
