"""Kernels give what the same function gives in Python, in all that their own lowering writes in fewer instructions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.base.compiled import cache
from irsim_gym.base.kernels import kernel, passes
from irsim_gym.base.kernels.structs import Struct, record_type

ROWS = record_type("x", lanes=3, count=np.int32)


@pytest.fixture(autouse=True, scope="module")
def _as_in_the_package() -> Iterator[None]:
    """Compile the kernels of this file as those of the package, and keep nothing of that on disk."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(passes, "PACKAGE", str(Path(__file__).parent))
        patch.setattr(cache, "files_of", lambda *_: None)
        yield


class Pair(NamedTuple):
    """Arrays in a tuple."""

    left: Floats
    right: Floats


@dataclass(repr=False)
class Store(Struct):
    """Arrays in a struct."""

    cube: Floats
    flat: Floats
    bytes: Any


@kernel
def elements(store: Store, pair: Pair, rows: Any, across: Floats, k: int, out: Floats) -> None:
    """Read and write elements and rows: indices from the end, transposed and narrow arrays, rows of records."""
    cube = store.cube
    row = cube[k, -1]
    out[0], out[1] = row[-1] + store.flat[k], cube[-1][k, 0]
    out[2] = across[k, -2] * 10.0 + across[-1][0]
    out[3] = cube[k].shape[0] + 100 * row.shape[0] + 10_000 * len(cube)
    row[0] = k
    store.bytes[-1] = k + 254
    out[4] = store.bytes[-1] + cube[k][-1, 0]
    out[5] = pair.left[k] - pair.right[-1]
    rows[k].x[-1] = 2.5
    rows[k].count = 7
    out[6] = rows[k].x[2] + rows[-1].count
    part = cube[k, 0, 1:]
    out[7] = part[0] + part.shape[0]
    for value in row:
        out[8] += value
    out[np.uint8(9)] = across.shape[0] + across.size


@kernel
def numbers(count: int, first: int, out: Ints) -> None:
    """Go through ranges, keep variables across blocks, and compute with numbers of several types."""
    last, total = -1, 0
    for i in range(count):
        if i == 3:
            continue
        last = i
        for j in range(i, count):
            total += i * j
            if j > 5:
                break
    out[0], out[1] = last, total
    for i in range(first, count):
        out[2] += i
    for i in range(count, first, -2):
        out[3] = 10 * out[3] + i
    for _ in range(first - count):
        out[4] = 1
    steps = range(count)
    for i in steps:
        for j in steps:
            out[5] += i ^ j
    is_even = count % 2 == 0
    while count:
        count, first = first % 2, count
        if first < 3:
            count = 0
    out[6] = first if is_even else -first
    out[7] = count**2 + (3 if is_even and last else 4) + int(7.9) + abs(-2) // 3


def test_elements_and_rows_are_those_of_numpy() -> None:
    """Each result is that of the same function in Python."""
    results = []
    for function in (elements, elements.__wrapped__):
        cube = np.arange(24.0).reshape(2, 3, 4)
        store = Store(cube, np.arange(3.0), np.zeros(3, np.uint8))
        rows, across = np.zeros(2, ROWS).view(np.recarray), np.arange(12.0).reshape(3, 4).T[::2]
        out = np.zeros(10)
        function(store, Pair(np.arange(2.0), np.arange(3.0)), rows, across, 1, out)
        results.append((out.tolist(), cube.tolist(), store.bytes.tolist(), rows.tobytes()))
    assert results[0] == results[1]


@pytest.mark.parametrize(("count", "first"), [(8, 2), (5, 7), (0, 0), (1, -3)])
def test_numbers_are_those_of_python(count: int, first: int) -> None:
    """Ranges may be empty, run backwards, and be used twice."""
    outs = np.zeros((2, 8), np.int64)
    numbers(count, first, outs[0])
    numbers.__wrapped__(count, first, outs[1])  # type: ignore[attr-defined]
    assert outs[0].tolist() == outs[1].tolist()
