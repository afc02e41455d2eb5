"""Arrays that are allocated from their own declaration: axes, dtype, unit and meaning."""

import dataclasses
import os
from collections.abc import Mapping
from dataclasses import dataclass
from math import prod
from typing import Any, ClassVar, Self, TypeVar

import numpy as np
from numpy.typing import DTypeLike

from irsim_gym.base.kernels.structs import Struct

CACHE_LINE = 64
GB = 1e9

A = TypeVar("A", bound=np.ndarray[Any, Any])


@dataclass(frozen=True)
class Column:
    """The declaration of one array.

    Attributes:
        axes: Names of its axes (or numbers, for a fixed length). ``world*`` is either the number of
            worlds or 1, which means that all worlds share the row.
        dtype: Its element type.
        unit: SI unit, e.g. ``"m"``.
        meaning: What it holds.
    """

    axes: tuple[str, ...]
    dtype: DTypeLike
    unit: str
    meaning: str

    def shape(self, sizes: Mapping[str, int], *, shared: bool) -> tuple[int, ...]:
        """Return the shape for given axis lengths."""
        return tuple(self._length(axis, sizes, shared) for axis in self.axes)

    @staticmethod
    def _length(axis: str, sizes: Mapping[str, int], shared: bool) -> int:
        if axis.isdigit():
            return int(axis)
        if axis == "world*":
            return 1 if shared else sizes["world"]
        return sizes[axis]


def column(axes: str, dtype: DTypeLike, unit: str, meaning: str) -> Any:
    """Declare an array field of an ``Arrays`` dataclass; ``axes`` is separated by spaces."""
    return dataclasses.field(metadata={"column": Column(tuple(axes.split()), dtype, unit, meaning)})


def aligned(shape: tuple[int, ...], dtype: DTypeLike) -> Any:
    """Return zeros that begin at a cache line: vectors that lie across two of them cost half as much again."""
    n_bytes = int(np.prod(shape)) * np.dtype(dtype).itemsize
    room = np.zeros(n_bytes + CACHE_LINE, np.uint8)
    # Up to the next multiple of CACHE_LINE.
    begin = -room.ctypes.data % CACHE_LINE
    return room[begin : begin + n_bytes].view(dtype).reshape(shape)


def frozen(values: A) -> A:
    """Return a copy that cannot be written into."""
    copied = values.copy()
    copied.flags.writeable = False
    return copied


class Arrays(Struct):
    """Base of the dataclasses whose fields are declared with ``column``.

    Attributes:
        together: Groups of fields of one shape and type that are rows of one array, in this order, so that one copy
            takes all; the groups follow each other in memory, as in a C struct.
    """

    together: ClassVar[tuple[tuple[str, ...], ...]] = ()

    def __repr__(self) -> str:
        arrays = [getattr(self, name) for name in self.columns()]
        n_bytes = sum(getattr(array, "nbytes", 0) for array in arrays)
        return f"<{type(self).__name__}: {len(arrays)} arrays, {n_bytes / 1e6:.3g} MB>"

    @classmethod
    def columns(cls) -> dict[str, Column]:
        """Return the declarations by field name."""
        return {f.name: f.metadata["column"] for f in dataclasses.fields(cls)}  # type: ignore[arg-type]

    @classmethod
    def allocate(cls, sizes: Mapping[str, int], *, per_world: frozenset[str] = frozenset()) -> Self:
        """Make zeroed arrays.

        Args:
            sizes: Length of each named axis.
            per_world: Fields with a ``world*`` axis that need a row for every world.

        Raises:
            MemoryError: This machine has less memory than they need.
        """
        columns = cls.columns()
        shapes = {name: column.shape(sizes, shared=name not in per_world) for name, column in columns.items()}
        _refuse_too_large(sum(prod(shapes[name]) * np.dtype(columns[name].dtype).itemsize for name in columns), sizes)
        arrays = {name: np.zeros(shape, columns[name].dtype) for name, shape in shapes.items()}
        return cls(**arrays | cls._side_by_side(arrays))

    @classmethod
    def _side_by_side(cls, arrays: Mapping[str, Any]) -> dict[str, object]:
        """Return the fields of ``together`` in one piece of memory."""
        groups = [(names, arrays[names[0]]) for names in cls.together]
        starts, end = [], 0
        for names, column in groups:
            # The next multiple of the item's size, so that every group is aligned for its type.
            starts.append(-(-end // column.itemsize) * column.itemsize)
            end = starts[-1] + len(names) * column.nbytes
        room = aligned((end,), np.uint8)
        placed: dict[str, Any] = {}
        for (names, column), start in zip(groups, starts, strict=True):
            block = room[start : start + len(names) * column.nbytes].view(column.dtype)
            placed |= zip(names, block.reshape(len(names), *column.shape), strict=True)
        return placed


def _refuse_too_large(n_bytes: int, sizes: Mapping[str, int]) -> None:
    """Raise before memory is taken that is not there: the system would grant it, and end the process later."""
    memory = total_memory()
    if memory is not None and n_bytes > memory:
        raise MemoryError(
            f"{sizes['world']:,} worlds of this scenario need at least {n_bytes / GB:,.1f} GB of memory, this machine "
            f"has {memory / GB:,.1f} GB: take fewer worlds or fewer bodies"
        )


def total_memory() -> int | None:
    """Return the memory of this machine [byte], None where the system does not tell."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return None
