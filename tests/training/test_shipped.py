"""What ships is learned with what ships: `irsim-gym train NAME`, and the committed table of what came out."""

from __future__ import annotations

import importlib.util
import json
import os
from pathlib import Path
from typing import Any

import pytest
import yaml

from irsim_gym.cli.work.commands import run_evaluation, run_training
from irsim_gym.evaluation.comparison.evaluate import TeamEvaluation
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.scenario.specs.library import scenario_names
from irsim_gym.training.requests.training_request import TrainingRequest

AGENTS = Path(__file__).parents[2] / "agents"
LEVELS = 1000
BY_HAND = "like_irsims_quick_start"
QUICK_START: dict[str, Any] = {
    "world": {
        "height": 12,
        "width": 12,
        "step_time": 0.1,
        "sample_time": 0.1,
        "offset": [-1, -1],
        "collision_mode": "stop",
        "plot": {"show_title": True, "figure_pixels": [900, 900]},
    },
    "robot": [
        {
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": 0.25},
            "state": [0.2, 9.8, 0],
            "goal": [9.8, 0.2, 0],
            "behavior": {"name": "dash"},
        }
    ],
    "obstacle": [
        {
            "number": 11,
            "distribution": {"name": "random"},
            "shape": [{"name": "circle", "radius": 1.1}, {"name": "rectangle", "length": 1.6, "width": 1.3}],
            "state": [[5, 6, 0], [4, 3, 0]],
        },
        {"shape": {"name": "rectangle", "length": 1.6, "width": 1.3}, "state": [5.5, 4.5, 2]},
        {
            "shape": {"name": "linestring", "vertices": [[6, 6], [3, 1], [2, 7]]},
            "state": [0, 0, 0],
            "unobstructed": True,
        },
    ],
}
"""A world with the features of IR-SIM's Quick Start: no sensor, the default limits and goal threshold (0.1 m), one
start and goal, and large obstacles anywhere, which leave dead ends."""


def _script() -> Any:
    """Return agents/studies/summarize_shipped.py as a module."""
    with pytest.MonkeyPatch.context() as patched:
        patched.syspath_prepend(str(AGENTS / "studies"))
        spec = importlib.util.spec_from_file_location("summarize_shipped", AGENTS / "studies" / "summarize_shipped.py")
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module


SCRIPT = _script()
LEARNED = tuple(name for name in scenario_names() if name not in SCRIPT.ELSEWHERE)


def rows() -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(SCRIPT.RESULTS.read_text())["runs"]
    return found


def test_every_shipped_scenario_has_reached_its_mark() -> None:
    found = rows()
    missing = set(LEARNED) - {row["scenario"] for row in found}
    assert not missing, "train them, see agents/studies/summarize_shipped.py"
    for row in found:
        assert row["success"]["value"] >= SCRIPT.MARKS.get(row["scenario"], SCRIPT.MARK), row["scenario"]
        assert row["conditions"]["levels"] == LEVELS
    for name in SCRIPT.ELSEWHERE:
        assert (AGENTS / "results" / f"{name}.json").is_file()


def test_the_table_of_the_page_is_that_of_the_results() -> None:
    page = SCRIPT.PAGE.read_text()
    assert SCRIPT.rewritten(page, rows()) == page, "run: python agents/studies/summarize_shipped.py"


def test_a_newer_run_takes_the_place_of_an_older_one() -> None:
    old, new, other = (
        {"scenario": name, "seed": seed, "spl": spl}
        for name, seed, spl in (("b", 0, 1.0), ("b", 0, 2.0), ("a", 1, 3.0))
    )
    assert SCRIPT.merged([old], [new, other]) == [other, new]


def trained(scenario: str, folder: Path) -> float:
    """Train as `irsim-gym train` does by default; return the success on `dev` levels, of a team that of all robots."""
    run = run_training(TrainingRequest(scenario), folder, resume=True, dev_levels=0)
    is_team = run.settings().hyperparameters.team is not None
    asked, how = ScenarioRequest(scenario, team=is_team), {"levels": LEVELS, "split": "dev", "out": folder / "dev"}
    found = run_evaluation(asked, [str(folder)], references=False, **how)
    if isinstance(found, TeamEvaluation):
        return found.summaries[0].cooperative_success.value
    return found.summaries[0].success.value


@pytest.mark.slow
@pytest.mark.parametrize("name", LEARNED)
def test_what_ships_is_learned(name: str, tmp_path: Path) -> None:
    """One of them: `pytest -k "learned and quick_start"`. SHIPPED_RUNS names a folder where runs stay and go on."""
    assert trained(name, Path(os.environ.get("SHIPPED_RUNS", tmp_path)) / name) >= SCRIPT.MARKS.get(name, SCRIPT.MARK)


@pytest.mark.slow
def test_a_world_like_irsims_quick_start_is_learned(tmp_path: Path) -> None:
    file = tmp_path / f"{BY_HAND}.yaml"
    file.write_text(yaml.safe_dump(QUICK_START))
    assert trained(str(file), Path(os.environ.get("SHIPPED_RUNS", tmp_path)) / BY_HAND) >= SCRIPT.MARKS[BY_HAND]
