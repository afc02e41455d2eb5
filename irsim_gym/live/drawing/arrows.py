"""The outlines of arrows."""

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.drawing.places import FARTHEST

HEAD_LENGTH, HEAD_WIDTH, NECK = 5.0, 3.0, 4.5
"""Length and width of a head, and distance from its tip to the shaft, in widths of the shaft."""
SLENDER = 16.0
"""Mean length of arrows in widths of their shafts, if no width is given."""


def outlines(rows: Floats, length: float | None, width: float | None) -> list[Floats]:
    """Return the corners of arrows, each of shape ``(7, 2)`` [m].

    An arrow shorter than its head is drawn smaller.

    Args:
        rows: Tail and vector of each arrow [m], shape ``(n, 4)``. Rows without direction, or not finite, are left out.
        length: Length of all arrows [m]; None for that of each vector.
        width: Width of the shafts [m]; None for a share of the mean length.
    """
    sizes = np.hypot(rows[:, 2], rows[:, 3])
    rows = rows[(np.abs(rows) < FARTHEST).all(axis=1) & (sizes > 0.0)]
    sizes = np.hypot(rows[:, 2], rows[:, 3])
    if not len(rows):
        return []
    ahead = rows[:, 2:] / sizes[:, None]
    long = sizes if length is None else np.full(len(rows), length)
    # The head is HEAD_LENGTH widths long, and must not be longer than the arrow.
    thick = np.minimum(long.mean() / SLENDER if width is None else width, long / HEAD_LENGTH)
    return [_outline(*row) for row in zip(rows[:, :2], ahead, long.tolist(), thick.tolist(), strict=True)]


def _outline(tail: Floats, ahead: Floats, length: float, width: float) -> Floats:
    half, wide = 0.5 * width, 0.5 * HEAD_WIDTH * width
    neck, barb = length - NECK * width, length - HEAD_LENGTH * width
    along = np.array([0.0, neck, barb, length, barb, neck, 0.0])
    aside = np.array([half, half, wide, 0.0, -wide, -half, -half])
    return np.asarray(tail + along[:, None] * ahead + aside[:, None] * np.array([-ahead[1], ahead[0]]))
