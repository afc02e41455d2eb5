"""Random scenarios with all features mixed: each step is ir-sim's, or the difference is a named decision."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from harness import Pair, Report, scenario_of
from hypothesis import HealthCheck, Phase, given, settings
from ir_sim import IrSim
from random_scenarios import cases
from translation import to_ir_sim

from irsim_gym.errors import ScenarioError

COMMON: dict[str, Any] = {
    "deadline": None,
    "derandomize": True,
    "database": None,
    "suppress_health_check": list(HealthCheck),
}


def compare(case: dict[str, Any], folder: Path) -> Report:
    try:
        pair = Pair(case, folder, seed=1)
    except ScenarioError as error:
        if "the start lies in" not in str(error):
            raise
        check_blocked_start(case, folder)
        return Report()
    return pair.single_steps()


def check_blocked_start(case: dict[str, Any], folder: Path) -> None:
    """Decision ``blocked_start``: in ir-sim the robot touches a static obstacle from the start."""
    reference = IrSim(to_ir_sim(scenario_of(case, folder), set()), folder)
    reference.env._objects_check_status()
    assert any(one.collision_flag and one.role == "robot" for one in reference.objects)


def compare_many(examples: int, folder: Path, phases: list[Phase]) -> None:
    reports = []

    @settings(max_examples=examples, phases=phases, **COMMON)
    @given(case=cases())
    def run(case: dict[str, Any]) -> None:
        reports.append(compare(case, folder))

    run()
    moves, beams = (sum(getattr(report, name) for report in reports) for name in ("moves", "beams"))
    assert moves > 4 * examples
    assert beams > 20 * examples
    assert sum(report.ties for report in reports) <= 0.02 * moves
    assert sum(report.grazes for report in reports) <= 0.01 * moves
    assert sum(report.grazing_beams for report in reports) <= 0.001 * beams


def test_random_scenarios_step_as_in_ir_sim(tmp_path: Path) -> None:
    compare_many(40, tmp_path, [Phase.generate])


@pytest.mark.slow
def test_many_random_scenarios_step_as_in_ir_sim(tmp_path: Path) -> None:
    compare_many(5000, tmp_path, [Phase.generate])
