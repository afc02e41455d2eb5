"""Arrays as compressed planes of bytes."""

from __future__ import annotations

import json
import zlib
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as stnp
from numpy.typing import NDArray

from irsim_gym.evaluation.byte_planes import DEFLATE, from_planes, layout_of, to_planes

KINDS = st.one_of(
    stnp.boolean_dtypes(),
    stnp.integer_dtypes(endianness="?"),
    stnp.unsigned_integer_dtypes(endianness="?"),
    stnp.floating_dtypes(endianness="?", sizes=(32, 64)),
)
SHAPES = stnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4)


@settings(deadline=None, max_examples=60)
@given(st.dictionaries(st.text(max_size=3), stnp.arrays(KINDS, SHAPES), max_size=4))
def test_arrays_come_back(arrays: dict[str, NDArray[Any]]) -> None:
    layout = json.loads(json.dumps(layout_of(arrays), sort_keys=True))
    found = from_planes(layout, to_planes(arrays))
    assert list(found) == list(arrays)
    for name, array in arrays.items():
        assert (found[name].shape, found[name].dtype) == (array.shape, array.dtype.newbyteorder("<"))
        np.testing.assert_array_equal(found[name], array)


def test_the_lowest_bytes_come_first() -> None:
    planes = to_planes({"a": np.array([0x0102, 0x0304], ">u2")})
    stream = zlib.decompressobj(DEFLATE)
    assert stream.decompress(planes.tobytes()) == bytes([0x02, 0x04])
    assert zlib.decompress(stream.unused_data, DEFLATE) == bytes([0x01, 0x03])


def test_what_does_not_fit_is_refused() -> None:
    planes = to_planes({"a": np.arange(300, dtype=np.uint16)})
    for layout, given_planes, said in (
        ([["a", "<u2", [299]]], planes, "a has no 299 numbers"),
        ([["a", "<u2", [301]]], planes, "a has no 301 numbers"),
        ([["a", "<u2", [300]]], planes[:-9], "a has no 300 numbers"),
        ([["a", "|u1", [300]]], planes, r"[0-9]+ bytes more than its arrays have"),
        ([["a", "|O", [300]]], planes, r"a is of type \|O and shape"),
        ([["a", "<u2", [-300]]], planes, r"a is of type <u2 and shape \[-300\]"),
    ):
        with pytest.raises(ValueError, match=said):
            from_planes(layout, given_planes)
    with pytest.raises(zlib.error):
        from_planes([["a", "<u2", [300]]], np.full(99, 255, np.uint8))
