"""Vectors that a world returns: flat arrays that refuse columns, or columns."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.simulator.world.arrays import frozen

COLUMNS_HINT = "load(..., columns=True) gives columns of shape (n, 1), as IR-SIM does"


class Vector(np.ndarray[Any, Any]):
    """A flat array that refuses to be combined with a column.

    NumPy would silently broadcast ``(n,)`` and ``(m, 1)`` to a matrix, and a script that expects IR-SIM's columns would
    go on with wrong numbers. Otherwise it is a NumPy array. Results of computations are plain arrays.
    """

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if method == "__call__" and ufunc.signature is None:
            _refuse_columns(inputs)
        if "out" in options:
            options["out"] = tuple(map(_plain, options["out"]))
        return getattr(ufunc, method)(*map(_plain, inputs), **options)

    def __getitem__(self, key: Any) -> Any:
        try:
            return super().__getitem__(key)
        except IndexError as error:
            if self.ndim == 1 and isinstance(key, tuple) and len(key) > 1:
                raise IndexError(f"{error}: this array is flat, index it with one number; {COLUMNS_HINT}") from None
            raise

    def __setitem__(self, key: Any, value: Any) -> None:
        if not self.flags.writeable:
            raise ValueError("this array is read-only: set_state, set_velocity and set_goal change a body")
        super().__setitem__(key, value)

    def __repr__(self) -> str:
        return repr(np.asarray(self))

    def __reduce__(self) -> Any:
        return np.asarray(self).__reduce__()


def _plain(value: object) -> Any:
    return np.asarray(value) if isinstance(value, Vector) else value


def _refuse_columns(inputs: tuple[Any, ...]) -> None:
    """Raise if one input is a ``Vector`` and another one a column.

    Raises:
        ValueError: They would give a matrix.
    """
    flat = max((value.size for value in inputs if isinstance(value, Vector) and value.ndim == 1), default=0)
    if flat < 2:
        return
    for value in inputs:
        shape = np.shape(value) if isinstance(value, np.ndarray | list | tuple) else ()
        if len(shape) == 2 and shape[0] > 1 and shape[1] == 1:
            raise ValueError(
                f"a flat array of shape ({flat},) and a column of shape {shape} would give a matrix of shape "
                f"({shape[0]}, {flat}): {COLUMNS_HINT}; if the matrix is meant, take np.asarray(...) of the flat one"
            )


def row_of(values: ArrayLike) -> Floats:
    """Return numbers as a flat row; an empty one if they are none."""
    try:
        return np.asarray(values, np.float64).reshape(-1)
    except (TypeError, ValueError):
        return np.zeros(0)


def vector(values: Floats, columns: bool) -> Floats:
    """Return a read-only copy of numbers, as a ``Vector`` or as a column ``(n, 1)``."""
    copied = frozen(values)
    return copied.reshape(-1, 1) if columns else copied.view(Vector)
