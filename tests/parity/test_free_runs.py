"""The same scenario left to itself in ir-sim 2.12.0 and here: equal until the first tie or named difference."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import pytest
from cases import all_cases, case_of, plan_of
from harness import Pair, Report

STEPS = 100
LONG = 200
NAMES = [name for name, case in all_cases().items() if plan_of(case).get("free_run", True)]


@cache
def free_run(name: str, steps: int) -> Report:
    with tempfile.TemporaryDirectory() as folder:
        return Pair(case_of(name), Path(folder)).free_run(steps)


@pytest.mark.parametrize("steps", [STEPS, pytest.param(LONG, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", NAMES)
def test_a_free_run_is_ir_sims_until_something_named_ends_it(name: str, steps: int) -> None:
    report = free_run(name, steps)
    print(f"{name}: {report.event} at step {report.steps}")
    assert report.event == "end" or report.steps >= plan_of(case_of(name)).get("ends_after", steps), report


def test_most_free_runs_go_through_to_the_end() -> None:
    reports = {name: free_run(name, STEPS) for name in NAMES}
    ended = [name for name, report in reports.items() if report.event == "end"]
    assert all(reports[name].steps == STEPS for name in ended)
    assert len(ended) >= 0.6 * len(NAMES), {name: (report.event, report.steps) for name, report in reports.items()}
