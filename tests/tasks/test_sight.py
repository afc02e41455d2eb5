"""What learners may run into although no observation shows it, and the note of `irsim-gym check`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from task_tools import BALL, ROBOT, scenario
from typer.testing import CliRunner

from irsim_gym.cli.app import app
from irsim_gym.tasks import load_task
from irsim_gym.tasks.definition.sight import unseen

PAIR = [ROBOT, {**ROBOT, "state": [2, 8, 0], "goal": [8, 8, 0]}]
MARK = {**BALL, "unobstructed": True}


def seeing(*names: str, endings: tuple[str, ...] = ("collided",)) -> dict[str, Any]:
    return {"name": "blank", "observations": list(names), "endings": list(endings)}


@pytest.mark.parametrize(
    ("robots", "obstacle", "task", "team", "hidden"),
    [
        ([ROBOT], BALL, "navigation", False, ""),
        ([{**ROBOT, "sensors": []}], BALL, "navigation", False, ""),
        ([ROBOT], BALL, seeing("goal", "velocity", "last_action", "goal_record", "trail"), False, "the obstacles"),
        ([ROBOT], BALL, seeing("goal", "has_arrived"), False, "the obstacles"),
        ([ROBOT], BALL, seeing("goal", "route"), False, ""),
        ([ROBOT], BALL, seeing("goal", endings=("arrived",)), False, ""),  # nothing happens when it collides
        ([ROBOT], MARK, seeing("goal"), False, ""),
        ([ROBOT], None, seeing("goal"), False, ""),
        (PAIR, BALL, seeing("goal"), False, "other robots and the obstacles"),
        (PAIR, BALL, seeing("neighbors"), False, "the obstacles"),
        (PAIR, None, seeing("neighbors"), False, ""),
        (PAIR, None, seeing("goal"), True, "each other"),
    ],
)
def test_what_nobody_sees(robots: Any, obstacle: Any, task: Any, team: bool, hidden: str) -> None:
    world = scenario(robots, obstacle)
    assert unseen(world, load_task(world, task, team=team)) == hidden


def test_a_map_that_nobody_sees() -> None:
    world = scenario([ROBOT], obstacle_map=np.eye(5, dtype=np.bool_)[:, ::-1])
    assert unseen(world, load_task(world, seeing("goal"))) == "the obstacles"


def test_check_notes_a_learner_that_sees_nothing(tmp_path: Path) -> None:
    file = tmp_path / "blind.yaml"
    hidden = [{"name": name, "use": False} for name in ("scan", "free_travel")]
    robot = {name: value for name, value in ROBOT.items() if name != "sensors"}
    data = {"robot": robot, "obstacle": BALL, "task": {"name": "navigation", "observations": hidden}}
    file.write_text(yaml.safe_dump(data))
    told = CliRunner().invoke(app, ["check", str(file)])
    assert told.exit_code == 0
    assert "robot_0: the learner observes nothing of the obstacles: a sensor" in told.output
    file.write_text(yaml.safe_dump(data | {"task": {"name": "navigation"}}))
    assert "observes nothing" not in CliRunner().invoke(app, ["check", str(file)]).output
