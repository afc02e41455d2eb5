"""Structs as arguments of kernels: called from Python, from kernels and recorded, copied, and without a compiler."""

from __future__ import annotations

import copy
import os
import pickle
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from irsim_gym.base.arraytypes import Flags, Floats, Ints
from irsim_gym.base.kernels import kernel, replay
from irsim_gym.base.kernels.structs import Struct
from irsim_gym.simulator.running.fused import Fused
from irsim_gym.simulator.world.group import Shard


@dataclass(repr=False)
class Rates(Struct):
    """Something inside of another struct."""

    rate: float
    pair: tuple[Flags, int]
    nothing: None = None


@dataclass(repr=False)
class Tables(Struct):
    """Something of every type."""

    grid: Floats
    rates: Rates
    is_on: bool
    out: Floats


@kernel
def weight(w: int, rates: Rates) -> float:
    """Return a number that every field has a part in."""
    flags, count = rates.pair
    known = 0.25 if rates.nothing is None else 0.0
    return rates.rate * count + known + (0.5 if flags[w] else 0.0)


@kernel
def add(worlds: Ints, tables: Tables) -> None:
    """Add a weight and a column of the grid in some worlds."""
    for w in worlds:
        tables.out[w] += weight(w, tables.rates) + tables.grid[w, 1] + (100.0 if tables.is_on else 0.0)


WORLDS = np.array([0, 2])
EXPECTED = [1.5 * -3 + 0.25 + 0.5 + 2.0 + 100.0, 0.0, 1.5 * -3 + 0.25 + 10.0 + 100.0]


def made() -> Tables:
    """Return tables whose grid has gaps between its columns."""
    flags = np.array([True, True, False])
    return Tables(np.arange(12.0).reshape(3, 4)[:, ::2], Rates(1.5, (flags, -3)), True, np.zeros(3))


def test_every_field_arrives_and_one_that_is_replaced_is_seen() -> None:
    tables, grid = made(), np.zeros((3, 2))
    add(WORLDS, tables)
    assert tables.out.tolist() == EXPECTED
    before, tables.out, tables.grid, tables.is_on = tables.out, np.ones(3), grid, False
    add(WORLDS, tables)
    assert tables.out.tolist() == [1.0 - 3.75, 1.0, 1.0 - 4.25]
    assert before.tolist() == EXPECTED


@pytest.mark.skipif(not replay.is_possible(), reason="nothing is recorded where nothing is compiled")
def test_recorded_calls_hold_the_fields_until_they_are_recorded_again() -> None:
    tables = made()
    function = Fused(lambda shard: add(shard.worlds, tables))
    function(Shard(WORLDS))
    assert function.programs[0] is not None
    assert tables.out.tolist() == EXPECTED
    before, tables.out = tables.out, np.zeros(3)
    function(Shard(WORLDS))
    assert (before.tolist(), tables.out.tolist()) == ([2 * value for value in EXPECTED], [0.0] * 3)
    function.forget()
    function(Shard(WORLDS))
    assert tables.out.tolist() == EXPECTED


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda tables: pickle.loads(pickle.dumps(tables))])
def test_copies_have_blocks_of_their_own(copied) -> None:
    tables = made()
    add(WORLDS, tables)
    other = copied(tables)
    other.out = np.zeros(3)
    add(WORLDS, other)
    assert (tables.out.tolist(), other.out.tolist()) == (EXPECTED, EXPECTED)


def test_without_a_compiler_kernels_get_the_dataclass() -> None:
    use = (
        "from tests.base import test_structs as mine; t = mine.made(); mine.add(mine.WORLDS, t); print(t.out.tolist())"
    )
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(
        [sys.executable, "-c", use], env=environment, cwd=Path(__file__).parents[2], capture_output=True, text=True
    )
    assert done.stdout == f"{EXPECTED}\n", done.stderr
