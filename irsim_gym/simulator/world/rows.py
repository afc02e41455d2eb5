"""Rows of arrays whose first axis is the world."""

from typing import Any

from numpy.typing import NDArray

from irsim_gym.base.kernels import kernel


@kernel
def row_of(values: NDArray[Any], w: int) -> int:
    """Return the row of world ``w`` in ``values``; a first axis of length 1 means that all worlds share the row.

    It compares, because ``w % n`` divides, which takes as long as all the rest of many a kernel.
    """
    return w if w < values.shape[0] else 0
