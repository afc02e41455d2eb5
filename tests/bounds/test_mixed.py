"""Random scenarios with all features mixed: no value out of its space, no hang, no error but those of the package.

A batch equals single worlds, whatever levels these played before, and levels from a file equal those that are drawn.
The long run compiles kernels; a sample in plain Python belongs to ``make test``.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

PLAYER = Path(__file__).parent / "play_mixed.py"
SAMPLE = (1005, 2)
"""First seed and number of scenarios that take about a second each in plain Python."""
COUNT, PARTS = 3000, 15


def play(*arguments: int, **variables: str) -> list[dict[str, Any]]:
    """Play scenarios in a process of their own, and return what came of each."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **variables}
    command = [sys.executable, str(PLAYER), *map(str, arguments)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    played = [json.loads(line) for line in done.stdout.splitlines()]
    faults = [f"seed {one['seed']}, after {one['ways']}:\n{one['error']}" for one in played if one["error"]]
    assert not faults, "\n".join(faults)
    return played


def test_a_sample_of_random_scenarios_stays_in_its_spaces() -> None:
    played = play(*SAMPLE, 2, NUMBA_DISABLE_JIT="1")
    assert len(played) == SAMPLE[1]
    assert all({"spaces", "levels"} <= set(one["ways"]) for one in played)
    assert any("respawn" in one["ways"] for one in played)  # not where learners wait for each other


@pytest.mark.slow
@pytest.mark.parametrize("part", range(PARTS))
def test_random_scenarios_stay_in_their_spaces(part: int) -> None:
    count = COUNT // PARTS
    played = play(part * count, count)
    assert len(played) == count
    assert sum("spaces" in one["ways"] for one in played) >= 0.5 * count
