"""Short names for array types, by what they hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Rays = NDArray[np.float32]
Ints = NDArray[np.int64]
Spans = NDArray[np.int32]
Flags = NDArray[np.bool_]
Bytes = NDArray[np.uint8]
Labels = NDArray[np.int32]
Words = NDArray[np.uint64]
Pixels = NDArray[np.uint32]
Record = np.record
Records = NDArray[np.record]
CellMap = tuple[Floats, Bytes, Ints, Rays]
