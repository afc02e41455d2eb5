"""The ways of evaluated policies: what is kept, and that looking changes nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from irsim_gym.evaluation.comparison.trajectory_figures import TrajectoryFigure
from irsim_gym.evaluation.measures.trajectories import TrajectoryLog
from irsim_gym.evaluation.policies.reference_policies import reference_policy
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.requests.episode_setup import make_episodes

DISC: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}, "vel_max": [1, 1]}


@pytest.fixture
def corridor(tmp_path: Any) -> str:
    """A robot that arrives after 12 steps of a quarter of a metre, and one that drives against a wall."""
    import yaml

    robots = [
        {**DISC, "state": [1, 1, 0], "goal": [4.1, 1, 0], "goal_threshold": 0.2},
        {**DISC, "state": [1, 3, 0], "goal": [5, 3, 0], "goal_threshold": 0.2},
    ]
    wall = {"shape": {"name": "rectangle", "length": 0.5, "width": 1}, "state": [3.05, 3, 0]}
    scenario = {
        "world": {"height": 4, "width": 6, "step_time": 0.25},
        "robot": robots,
        "obstacle": [wall],
        "task": {"name": "navigation", "max_steps": 40},
    }
    file = tmp_path / "corridor.yaml"
    file.write_text(yaml.safe_dump(scenario), encoding="utf-8")
    return str(file)


def test_the_ways_of_a_team(corridor: str) -> None:
    episodes = make_episodes(corridor, n_worlds=2, team=True)
    ways = TrajectoryLog(episodes, shown=2)
    evaluate_team(reference_policy("dash"), episodes, 3, watcher=ways)
    assert sorted((way.level, way.outcome) for way in ways.ways) == [
        (level, outcome) for level in range(3) for outcome in ("collision", "success")
    ]
    arrived = next(way for way in ways.ways if (way.level, way.outcome) == (1, "success"))
    assert arrived.points == pytest.approx(np.column_stack([1.0 + 0.25 * np.arange(13), np.ones(13)]))
    assert arrived.goal.tolist() == [4.1, 1.0]
    struck = next(way for way in ways.ways if (way.level, way.outcome) == (0, "collision"))
    assert struck.points[:, 0] == pytest.approx(1.0 + 0.25 * np.arange(8))  # its rim touches the wall at 2.8
    only_end = next(way for way in ways.ways if (way.level, way.outcome) == (2, "collision"))
    assert only_end.points == pytest.approx(np.array([[2.75, 3.0]]))


def test_watching_changes_nothing() -> None:
    rows = []
    for n_worlds, watched in ((3, False), (3, True), (5, True)):
        episodes = make_episodes("empty_goal", n_worlds=n_worlds)
        ways = TrajectoryLog(episodes, shown=4) if watched else None
        rows.append(evaluate(reference_policy("random"), episodes, 6, watcher=ways))
        if ways is not None:
            found = {way.level: way for way in ways.ways}
            assert sorted(found) == list(range(6))
            assert [len(found[level].points) for level in range(6)] == [
                rows[0][level].steps + 1 if level < 4 else 1 for level in range(6)
            ]
            assert [found[level].outcome for level in range(6)] == [row.outcome for row in rows[0]]
    assert rows[0] == rows[1] == rows[2]


def test_the_figure_gets_ways_counts_and_obstacles(
    corridor: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The obstacles of the corridor stand in all of its levels; those of ``cluttered_room`` are drawn anew."""
    shown: list[Any] = []
    monkeypatch.setattr("irsim_gym.rendering.figures.ways_plot.draw_ways", lambda *given: shown.append(given))
    for scenario in (corridor, "cluttered_room"):
        episodes = make_episodes(scenario, n_worlds=2, team=True)
        atlas = TrajectoryFigure(episodes)
        evaluate_team(reference_policy("dash"), episodes, 4, watcher=atlas.follow("dash"))
        atlas.draw(tmp_path, "title", {"dash": "said"}, 4)
    (_, (alike,), fixed, *_, note), (_, _, drawn, *_, other) = shown
    assert alike.counts == {"success": 4, "collision": 4}
    assert [way.outcome for way in alike.ways].count("success") == 4
    assert (fixed.differs, drawn.differs) == (False, True)
    assert "from 4 levels" in note
    assert ("darker" in note, "darker" in other) == (False, True)
