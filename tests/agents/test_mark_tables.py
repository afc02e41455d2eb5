"""The tables of five seeds in agents/README.md, and the policies on the shelf that are of these seeds."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import pytest

from irsim_gym.evaluation.saved_policies.shelf import card_of
from irsim_gym.evaluation.suite.members import shipped_suite

STUDIES = Path(__file__).parents[2] / "agents" / "studies"


with pytest.MonkeyPatch.context() as patched:
    patched.syspath_prepend(str(STUDIES))
    SCRIPT: Any = importlib.import_module("summarize_marks")
MARKS = [mark for mark in SCRIPT.MARKS if SCRIPT.read(mark.name) is not None]


def test_the_tables_of_the_page_are_those_of_the_results() -> None:
    page = SCRIPT.PAGE.read_text(encoding="utf-8")
    assert SCRIPT.rewritten(page) == page, "run: python agents/studies/summarize_marks.py"


@pytest.mark.parametrize("mark", MARKS, ids=lambda mark: mark.name)
def test_five_seeds_play_the_test_levels(mark: Any) -> None:
    found = SCRIPT.read(mark.name)
    assert [seed["settings"]["seed"] for seed in found["seeds"]] == [0, 1, 2, 3, 4]
    assert (found["conditions"]["split"], found["conditions"]["levels"]) == ("test", mark.levels)
    member = shipped_suite().members[mark.benchmark]
    assert found["conditions"]["scenario"] == member.scenario
    assert all(found["conditions"]["parameters"][name] == value for name, value in member.parameters.items())


@pytest.mark.parametrize("mark", MARKS, ids=lambda mark: mark.name)
def test_the_policy_on_the_shelf_is_a_seed_of_median_success(mark: Any) -> None:
    found, card = SCRIPT.read(mark.name), card_of(mark.name)
    assert card is not None
    assert card.training.seeds == (0, 1, 2, 3, 4)
    (own,) = [seed for seed in found["seeds"] if seed["settings"]["seed"] == card.training.seed]
    assert len(card.results) == 1 or card.training.mixture
    (result,) = [one for one in card.results if one.level_hash == found["conditions"]["level_hash"]]
    assert result.success.model_dump() == own["test"]["success"]
    assert result.success.value == found["median_test_success"]
    assert result.seeds == {seed["run"]: seed["test"]["success"]["value"] for seed in found["seeds"]}


def test_rows_of_other_benchmarks_are_those_of_the_seeds_alone() -> None:
    rows = [SCRIPT.played_row(place, found) for place in SCRIPT.ELSEWHERE if (found := SCRIPT.read(place.name))]
    assert rows
    assert all(len(row[3].split(", ")) == 5 for row in rows)
