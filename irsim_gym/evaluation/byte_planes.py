"""Arrays of numbers in few bytes: the lowest byte of every number, then the next one, each such plane compressed alone.

The upper bytes of neighbouring numbers (exponents, small counts) are alike, which ``zlib`` sees only side by side.
"""

import math
import zlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Bytes

Layout = Sequence[tuple[str, str, list[int]]]
"""Name, type as NumPy writes it (``"<f4"``) and shape of each array, in their order: plain data, which JSON holds."""
NUMBERS = "biuf"
"""Kinds of types that are read: Booleans, integers and floating-point numbers."""
DEFLATE = -15
"""What ``zlib`` calls streams without header and checksum, which the archive around them has."""


def layout_of(arrays: Mapping[str, NDArray[Any]]) -> Layout:
    """Return the layout with which ``from_planes`` reads arrays again."""
    return [(name, _little(array).dtype.str, list(array.shape)) for name, array in arrays.items()]


def to_planes(arrays: Mapping[str, NDArray[Any]]) -> Bytes:
    """Return the compressed planes of arrays, one after the other, shape ``(n_bytes,)``."""
    content = bytearray()
    for array in map(_little, arrays.values()):
        for plane in array.reshape(-1).view(np.uint8).reshape(array.size, array.itemsize).T:
            # LZMA would save another 3 %, but Python may be built without it.
            press = zlib.compressobj(9, zlib.DEFLATED, DEFLATE, 9)
            content += press.compress(plane.tobytes()) + press.flush()
    return np.frombuffer(bytes(content), np.uint8)


def from_planes(layout: Layout, planes: Bytes) -> dict[str, NDArray[Any]]:
    """Return the arrays that ``to_planes`` has written.

    Args:
        layout: What ``layout_of`` has returned for them.
        planes: The compressed planes, shape ``(n_bytes,)``.

    Raises:
        ValueError: The planes are not those of the layout, or a type is not one of numbers.
        zlib.error: The bytes are no planes.
    """
    rest, arrays = planes.tobytes(), {}
    for name, kind_name, shape in layout:
        kind, count = np.dtype(kind_name), math.prod(shape)
        if kind.kind not in NUMBERS or count < 0:
            raise ValueError(f"{name} is of type {kind_name} and shape {shape}")
        content = []
        for _ in range(kind.itemsize):
            stream = zlib.decompressobj(DEFLATE)
            plane = stream.decompress(rest, count + 1)
            if len(plane) != count or not stream.eof:
                raise ValueError(f"{name} has no {count:,} numbers")
            content.append(np.frombuffer(plane, np.uint8))
            rest = stream.unused_data
        arrays[name] = np.stack(content, axis=1).reshape(-1).view(kind).reshape(shape)
    if rest:
        raise ValueError(f"{len(rest):,} bytes more than its arrays have")
    return arrays


def _little(array: NDArray[Any]) -> NDArray[Any]:
    """Return an array in one piece whose numbers have their lowest byte first."""
    return np.asarray(array, array.dtype.newbyteorder("<"), order="C")
