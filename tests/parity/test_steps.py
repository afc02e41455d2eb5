"""The same scenario and the same actions in ir-sim 2.12.0 and here, one step at a time."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import pytest
from cases import all_cases, case_of
from decisions import DECISIONS
from harness import Pair, Report


@cache
def step_report(name: str) -> Report:
    with tempfile.TemporaryDirectory() as folder:
        return Pair(case_of(name), Path(folder)).single_steps()


@pytest.mark.parametrize("name", list(all_cases()))
def test_each_step_is_ir_sims(name: str) -> None:
    report = step_report(name)
    print(name, report)
    assert report.moves > 0
    assert report.grazing_beams <= max(3, 0.001 * report.beams)
    assert report.decisions <= DECISIONS.keys()


def test_ties_and_grazes_are_rare() -> None:
    reports = {name: step_report(name) for name in all_cases()}
    total = {
        key: sum(getattr(report, key) for report in reports.values())
        for key in ("steps", "moves", "beams", "ties", "grazes", "grazing_beams")
    }
    print(total)
    assert len(reports) >= 60
    assert total["ties"] <= 0.01 * total["moves"]
    assert total["grazes"] <= 0.005 * total["moves"]
    assert total["grazing_beams"] <= 0.001 * total["beams"]
    # Each kind of allowance is met somewhere, so that none of them is a dead letter.
    assert min(total.values()) > 0
