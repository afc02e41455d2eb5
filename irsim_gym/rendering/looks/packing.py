"""Compact storage: compressed frames in memory, and tables of numbers as short JSON."""

import zlib
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Bytes

METRE, RADIAN = 1e-3, 1e-4
"""Units of lengths and angles in a replay; the maximum error is half a unit."""


@dataclass(frozen=True)
class PackedFrame:
    """A compressed picture; with flat colours, it needs a few percent of the memory.

    Attributes:
        shape: Its height, width and number of channels.
        content: Its bytes, deflated.
    """

    shape: tuple[int, ...]
    content: bytes

    @classmethod
    def of(cls, frame: Bytes) -> Self:
        """Pack a picture, uint8, shape ``(height, width, 3)``."""
        return cls(frame.shape, zlib.compress(frame.tobytes(), 1))

    def frame(self) -> Bytes:
        """Return the picture, read-only."""
        return np.frombuffer(zlib.decompress(self.content), np.uint8).reshape(self.shape)


def packed(rows: ArrayLike, unit: float, *, still: bool = True) -> dict[str, Any]:
    """Return numbers as a unit and whole-numbered differences along the first axis.

    Args:
        rows: Numbers, shape ``(n,)`` or ``(n, width)``; NaN for missing ones.
        unit: Unit to which the numbers are rounded.
        still: Whether to store only one row if all rows are equal.

    Returns:
        ``unit``, ``width``, and ``values``: the rows concatenated, with None for NaN. A difference is relative to the
        latest number of its column, or to 0.
    """
    table = np.asarray(rows, np.float64)
    table = table.reshape(len(table), -1)
    whole = np.rint(table / unit)
    if still and len(whole) > 1 and np.array_equal(whole, np.broadcast_to(whole[0], whole.shape), equal_nan=True):
        whole = whole[:1]
    absent = np.isnan(whole)
    # For each row and column, the latest row with a number, counted from 1; row 0 of ``padded`` is the 0 before.
    numbers = np.where(absent, 0, np.arange(1, len(whole) + 1)[:, None])
    latest = np.maximum.accumulate(numbers, axis=0)
    padded = np.vstack([np.zeros((1, whole.shape[1])), np.nan_to_num(whole)])
    held = np.take_along_axis(padded, latest, axis=0)
    steps = np.diff(held, axis=0, prepend=0.0).astype(np.int64).ravel().tolist()
    values = [None if gone else step for step, gone in zip(steps, absent.ravel().tolist(), strict=True)]
    return {"unit": unit, "width": whole.shape[1], "values": values}
