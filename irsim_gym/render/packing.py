"""Compact forms of what is kept: frames in memory, and rows of numbers as short JSON."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.arraytypes import Bytes, Floats

METRE, RADIAN = 1e-3, 1e-4
"""Units in which a replay holds lengths and angles; half of one is the largest error."""


@dataclass(frozen=True)
class PackedFrame:
    """A compressed picture; flat colours leave a few percent of it.

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
        """Return the picture; it cannot be written."""
        return np.frombuffer(zlib.decompress(self.content), np.uint8).reshape(self.shape)


def packed(rows: ArrayLike, unit: float, *, still: bool = True) -> dict[str, Any]:
    """Return numbers as a unit and whole numbers, differences along the first axis.

    Args:
        rows: Shape ``(n,)`` or ``(n, width)``; NaN where there is none.
        unit: What the numbers are rounded to.
        still: Let one row stand for any number of equal ones.

    Returns:
        ``unit``, ``width``, and ``values``: row after row, None for NaN. A difference is taken from the latest number
        of its column, or from 0.
    """
    table = np.asarray(rows, np.float64)
    table = table.reshape(len(table), -1)
    whole = np.rint(table / unit)
    if still and len(whole) > 1 and np.array_equal(whole, np.broadcast_to(whole[0], whole.shape), equal_nan=True):
        whole = whole[:1]
    absent = np.isnan(whole)
    known = np.where(absent, 0, np.arange(1, len(whole) + 1)[:, None])
    latest = np.maximum.accumulate(known, axis=0)
    padded = np.vstack([np.zeros((1, whole.shape[1])), np.nan_to_num(whole)])
    held = np.take_along_axis(padded, latest, axis=0)
    steps = np.diff(held, axis=0, prepend=0.0).astype(np.int64).ravel().tolist()
    values = [None if gone else step for step, gone in zip(steps, absent.ravel().tolist(), strict=True)]
    return {"unit": unit, "width": whole.shape[1], "values": values}


def unpacked(data: Mapping[str, Any], count: int) -> Floats:
    """Return the numbers that were packed, shape ``(count, width)``."""
    values: Sequence[int | None] = data["values"]
    table = np.array([np.nan if value is None else value for value in values], np.float64).reshape(-1, data["width"])
    sums = np.where(np.isnan(table), np.nan, np.cumsum(np.nan_to_num(table), axis=0)) * data["unit"]
    return np.array(np.broadcast_to(sums, (count, data["width"])) if len(sums) == 1 else sums)
