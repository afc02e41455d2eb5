"""The same scenario and the same actions in ir-sim 2.12.0 and here, one step at a time."""

from __future__ import annotations

from pathlib import Path

import pytest
from cases import all_cases, case_of, refused
from harness import Pair


@pytest.mark.parametrize("name", list(all_cases()))
def test_each_step_is_ir_sims(name: str, tmp_path: Path) -> None:
    if refused(name):
        pytest.skip("not supported yet")
    report = Pair(case_of(name), tmp_path).single_steps()
    assert report.moves > 0
    print(name, report)
