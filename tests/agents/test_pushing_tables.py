"""The tables of pushing in agents/README.md and docs/benchmarks.md are those of agents/results."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

import pytest

from irsim_gym.training import percent

ROOT = Path(__file__).parents[2]
SCENARIOS = ("push_box", "clear_doorway")


def results(name: str) -> Any:
    return json.loads((ROOT / "agents" / "results" / f"{name}.json").read_text(encoding="utf-8"))


def table(page: str, heading: str) -> list[list[str]]:
    """Return the cells of the rows of the only table below a heading."""
    text = (ROOT / page).read_text(encoding="utf-8").partition(f"\n{heading}\n")[2].partition("\n#")[0]
    lines = [line for line in text.split("\n") if line.startswith("|")]
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines[2:]]


def cells(rows: Sequence[Any]) -> list[str]:
    """Return success [%], bodies in their targets [%], effort [J] and time [s]: medians and ranges over the rows."""
    columns = [
        [100 * row["success"]["value"] for row in rows],
        [None if row["delivered"] is None else 100 * row["delivered"] for row in rows],
        [row["effort"] for row in rows],
        [row["time"] for row in rows],
    ]
    return [middle(column) for column in columns]


def middle(column: Sequence[float | None]) -> str:
    known = [value for value in column if value is not None]
    if not known:
        return "-"
    low, high = f"{min(known):.1f}", f"{max(known):.1f}"
    return low if len(known) == 1 else f"{median(known):.1f} ({low}-{high})"


@pytest.mark.parametrize("name", SCENARIOS)
def test_each_seed_has_its_row(name: str) -> None:
    found = results(name)
    assert [seed["settings"]["seed"] for seed in found["seeds"]] == [0, 1, 2, 3, 4]
    assert (found["conditions"]["split"], found["conditions"]["levels"]) == ("test", 1000)
    expected = [
        [f"`{name}`", str(seed["settings"]["seed"]), percent(seed["test"]["success"]), *cells([seed["test"]])[1:]]
        for seed in found["seeds"]
    ]
    costs = [[f"{seed['cpu_seconds']:.0f}", f"{seed['steps']:,}"] for seed in found["seeds"]]
    rows = [row for row in table("agents/README.md", "### Pushing") if row[0] == f"`{name}`"]
    assert rows == [[*row, *cost] for row, cost in zip(expected, costs, strict=True)]


@pytest.mark.parametrize("name", SCENARIOS)
def test_the_benchmark_page_has_medians_and_ranges(name: str) -> None:
    found = results(name)
    expected = [[f"`{name}`", "learned, 5 seeds", *cells([seed["test"] for seed in found["seeds"]])]]
    expected += [[f"`{name}`", f"`{row['policy']}`", *cells([row])] for row in found["references"]]
    assert [row for row in table("docs/benchmarks.md", "## Pushing") if row[0] == f"`{name}`"] == expected
