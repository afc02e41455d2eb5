"""How many goals robots reach that have several, against hand calculations."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.evaluation.measures.metrics import EpisodeRow, summarize
from irsim_gym.evaluation.measures.team_metrics import TeamRow, summarize_team
from irsim_gym.evaluation.policies.reference_policies import reference_policy
from irsim_gym.evaluation.protocol.figure_columns import summary_table
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.protocol.tables import table_text
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.suite.row_files import read_rows, write_rows
from irsim_gym.evaluation.suite.scores import score_member

LIMIT = 100
GOALS = [[2.0, 2.0], [4.0, 2.0], [6.0, 2.0]]
TASK = {"name": "blank", "observations": ["goal"], "rewards": ["progress"], "endings": ["arrived", "collided"]}


def scenario(limit: int = LIMIT, **other: Any) -> dict[str, Any]:
    """Two robots that drive at 1 m/s to the right, each in its row; the second has what ``other`` says."""
    own = {"kinematics": {"name": "omni"}, "vel_max": [1, 1], "goal_threshold": 0.15, "shape": {"name": "circle"}}
    first = {**own, "state": [1, 2, 0], "goal": GOALS}
    second = {**own, "state": [1, 6, 0], "goal": [[x, 6.0] for x, _ in GOALS], **other}
    task = {**TASK, "max_steps": limit}
    return {"world": {"width": 10, "height": 10, "step_time": 0.1}, "robot": [first, second], "task": task}


def driven(data: dict[str, Any]) -> TeamRow:
    (row,) = evaluate_team(reference_policy("dash"), Worlds(data, 1, team=True).episodes, 1)
    return row


def test_who_reaches_all_goals_is_measured_by_its_own_time() -> None:
    row = driven(scenario())
    # 5 m at 1 m/s; the last step ends nearer than 0.15 m to the goal.
    assert [agent.episode.goals_reached for agent in row.agents] == [3.0, 3.0]
    for agent in row.agents:
        assert agent.episode.time == pytest.approx(4.9)
        assert agent.episode.goals_per_minute == pytest.approx(60 * 3 / 4.9)
    assert row.throughput == pytest.approx(2 * 60 * 3 / 4.9)


def test_who_does_not_is_measured_by_the_time_limit() -> None:
    box = {"shape": {"name": "rectangle", "length": 0.2, "width": 2}, "state": [5, 6, 0]}
    row = driven({**scenario(), "obstacle": [box]})
    assert [agent.episode.outcome for agent in row.agents] == ["success", "collision"]
    assert [agent.episode.goals_reached for agent in row.agents] == [3.0, 2.0]
    assert row.agents[1].episode.goals_per_minute == pytest.approx(60 * 2 / (0.1 * LIMIT))
    assert summarize_team("dash", [row]).goals_per_collision == 5.0
    late = driven(scenario(limit=20))
    assert [agent.episode.outcome for agent in late.agents] == ["timeout", "timeout"]
    assert [agent.episode.goals_reached for agent in late.agents] == [1.0, 1.0]
    assert late.throughput == pytest.approx(2 * 60 / 2.0)


def test_robots_with_one_goal_have_no_throughput() -> None:
    row = driven(scenario(goal=[6, 6]))
    assert math.isnan(row.agents[1].episode.goals_reached)
    assert math.isnan(row.agents[1].episode.goals_per_minute)
    assert row.throughput == row.agents[0].episode.goals_per_minute
    lone = TeamRow(row.level, row.limit, row.agents[1:])
    assert math.isnan(lone.throughput)
    assert "goals" not in table_text(summary_table([summarize_team("dash", [lone])], "one goal"))


def test_tables_and_files_have_the_throughput(tmp_path: Path) -> None:
    row = driven(scenario())
    text = table_text(summary_table([summarize_team("dash", [row])], "jobs"))
    assert text.split()[-1] == f"{row.throughput:.2f}"
    write_rows(tmp_path / "rows.csv", [row])
    (found,) = read_rows(tmp_path / "rows.csv")
    assert found.throughput == pytest.approx(row.throughput, abs=1e-5)
    assert score_member({"dash": [[found]]})["dash"]["throughput"] == pytest.approx(row.throughput, abs=1e-5)


def test_a_robot_alone() -> None:
    data = scenario()
    alone = {**data, "robot": data["robot"][:1]}
    rows: list[EpisodeRow] = evaluate(reference_policy("dash"), Worlds(alone, 1).episodes, 1)
    assert summarize("dash", rows).throughput == pytest.approx(60 * 3 / 4.9)
    assert table_text(summary_table([summarize("dash", rows)], "jobs")).split()[-1] == "36.73"
