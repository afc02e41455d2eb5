"""The reward obstruction: who has arrived pays for standing in the way of others."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import ROBOT, drive, play

from irsim_gym.tasks import Episodes

WAITS: dict[str, Any] = {"endings": [{"name": "arrived", "wait": True}]}


def robot(x: float, y: float, goal: tuple[float, float]) -> dict[str, Any]:
    return {**ROBOT, "state": [x, y, 0], "goal": [*goal, 0]}


def team(robots: list[dict[str, Any]], rewards: list[Any]) -> Episodes:
    return play(robots, None, {"name": "blank", "observations": ["velocity"], "rewards": rewards, **WAITS}, team=True)


OBSTRUCTION = {"name": "obstruction", "weight": 5.0}


def cost(episodes: Episodes) -> list[float]:
    column = episodes.reward_names.index("obstruction")
    found: list[float] = episodes.view.reward_terms[0, :, column].tolist()
    return found


def test_who_has_arrived_pays_for_being_in_the_way() -> None:
    """Robot 0 arrives at once, 0.5 m beside the way of robot 1."""
    episodes = team([robot(5, 5, (5.2, 5)), robot(3, 5.5, (9, 5.5))], rewards=[OBSTRUCTION])
    drive(episodes, 0, 0)
    assert episodes.state.arrival[0].tolist() == [1, 0]
    for step in range(1, 36):
        episodes.step(np.array([[[-1.0, 0.0], [1.0, 0.0]]]))
        x = episodes.simulation.state.pose[0, 1, 0]
        own, others = cost(episodes)
        assert others == 0.0
        if x < 4.9:
            assert own == pytest.approx(-5.0 / episodes.task.max_steps * (1 - 0.5 / 0.9), rel=0.15), step
        elif x > 6.0:
            assert own == 0.0
    assert x > 6.0


@pytest.mark.parametrize(("options", "pays"), [({}, True), ({"width": 0.2}, False), ({"ahead": 1.0}, False)])
def test_what_is_far_away_or_late_costs_nothing(options: Any, pays: bool) -> None:
    robots = [robot(5, 5, (5.2, 5)), robot(3, 5.3, (9, 5.3))]
    episodes = team(robots, rewards=[{**OBSTRUCTION, **options}])
    for _ in range(2):
        drive(episodes, -1, 0)
    assert (cost(episodes)[0] < 0.0) == pays


def test_nobody_pays_where_nobody_is_on_its_way_and_nobody_has_arrived() -> None:
    episodes = team([robot(5, 5, (9, 5)), robot(3, 5.3, (9, 5.3))], rewards=[OBSTRUCTION])
    for _ in range(5):
        drive(episodes, -1, 0)
        assert cost(episodes) == [0.0, 0.0]
    episodes = team([robot(5, 5, (5.2, 5)), robot(3, 5.3, (3.2, 5.3))], rewards=[OBSTRUCTION])
    drive(episodes, -1, 0)
    assert cost(episodes) == [0.0, 0.0]


def test_of_several_ways_the_nearest_is_paid_for() -> None:
    """So a whole episode never costs more than the weight."""
    others = [robot(3, 5.3, (9, 5.3)), robot(3, 4.8, (9, 4.8))]
    both = team([robot(5, 5, (5.2, 5)), *others], rewards=[OBSTRUCTION])
    one = team([robot(5, 5, (5.2, 5)), others[1]], rewards=[OBSTRUCTION])
    for episodes in (both, one):
        for _ in range(2):
            drive(episodes, -1, 0)
    assert cost(both)[0] == cost(one)[0] < -0.7 * 5.0 / both.task.max_steps
