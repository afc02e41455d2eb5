"""No kernel reads or writes beyond its arrays: compiled code does not look, and what it overwrites is anybody's.

Kernels run as plain Python here, with arrays that also refuse an index that counts from the end (``guard``): that finds
more than Numba's own checks, and costs less than to compile every kernel with them. A compiled run with those is in
``test_compilation``. ``make test-bounds`` plays everything; a sample belongs to ``make test``.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
STEPS = 2
PARTS = 16
SEEDS = range(1, 4)
RANDOM = 6
"""Random scenarios for each seed."""

SAMPLE = (
    "loop between what is drawn", "scanner of one beam", "crowd that dashes", "shipped circle_swap",
    "shipped four_drives", "shipped social_forces", "shipped goals_in_order", "parity collisions/head_on_stop",
    "documented random polygon", "tracks of bodies that pass",
)  # fmt: skip
"""Scenarios that take a second or two each in plain Python."""


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python with plain kernels in a process of its own."""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join([str(HERE), *sys.path])}
    return subprocess.run([sys.executable, *arguments], env=environment, capture_output=True, text=True, check=False)


def play(**what: Any) -> list[dict[str, Any]]:
    """Play scenarios, and return what came of each that can be played at all."""
    done = run(str(HERE / "play.py"), json.dumps({**what, "steps": STEPS}))
    assert done.returncode == 0, done.stderr
    played = [json.loads(line) for line in done.stdout.splitlines()]
    assert not [one["error"] for one in played if one["error"]], "\n".join(
        f"{one['name']}, after {one['ways']}:\n{one['error']}" for one in played if one["error"]
    )
    assert all("alone" in one["ways"] for one in played), [one["name"] for one in played if "alone" not in one["ways"]]
    return played


def test_a_sample_stays_within_its_arrays() -> None:
    played = play(names=SAMPLE)
    assert [one["name"] for one in played] == list(SAMPLE)
    ways = {way for one in played for way in one["ways"]}
    assert ways == {"alone", "by hand", "learner", "numbers", "pictures", "team", "respawn", "drawn"}


@pytest.mark.slow
@pytest.mark.parametrize("part", range(PARTS))
def test_everything_that_is_shipped_documented_or_compared_stays_within_its_arrays(part: int) -> None:
    played = play(part=(part, PARTS))
    assert len(played) >= 10
    assert sum("learner" in one["ways"] for one in played) >= 0.5 * len(played)
    assert sum("respawn" in one["ways"] for one in played) >= 0.4 * len(played)


@pytest.mark.slow
@pytest.mark.parametrize("number", SEEDS)
@pytest.mark.parametrize("sort", ["random", "drawn"])
def test_random_scenarios_stay_within_their_arrays(sort: str, number: int) -> None:
    played = play(random=(sort, number, RANDOM))
    assert len(played) == RANDOM


PROBE = """
import guard
guard.install()
from dataclasses import dataclass
import numpy as np
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import Struct

@dataclass
class Tables(Struct):
    pair: tuple

@kernel
def inner(tables, row):
    first, records = tables.pair
    return first[0, row], records[0].near[row]

@kernel
def outer(tables, row):
    return inner(tables, row)

records = np.zeros(2, np.dtype((np.record, [("near", np.float64, (3,))])))
tables = Tables((np.zeros((2, 3)), records))
print(outer(tables, 2))
outer(tables, {row})
"""


@pytest.mark.parametrize(("row", "told"), [(3, "index 3 is out of bounds"), (-1, "index -1 counts from the end")])
def test_an_index_beyond_either_end_is_found_in_kernels_that_kernels_call(row: int, told: str) -> None:
    done = run("-c", PROBE.format(row=row))
    assert done.stdout == "(np.float64(0.0), np.float64(0.0))\n"
    assert done.stderr.splitlines()[-1].startswith(f"IndexError: {told}"), done.stderr
