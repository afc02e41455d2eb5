"""The observation shared_ways and the reward obstruction: robots that make way for each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import BALL, ROBOT, drive, play

from irsim_gym.tasks import Episodes
from irsim_gym.tasks.observations.shared_ways import nearest_point

DIAGONAL = np.hypot(10, 10)
WAITS: dict[str, Any] = {"endings": [{"name": "arrived", "wait": True}]}
CELL = 10 / 64


def robot(x: float, y: float, goal: tuple[float, float], heading: float = 0.0, **more: Any) -> dict[str, Any]:
    return {**ROBOT, "state": [x, y, heading], "goal": [*goal, 0], **more}


def team(robots: list[dict[str, Any]], obstacle: Any = None, rewards: Any = (), **options: Any) -> Episodes:
    """Return a team that observes its shared ways alone."""
    task = {"name": "blank", "observations": [{"name": "shared_ways", **options}], "rewards": list(rewards), **WAITS}
    return play(robots, obstacle, task, team=True)


def seen(episodes: Episodes, agent: int) -> tuple[list[float], list[float]]:
    """Return an agent's columns: those of its own way, and those of another's."""
    row = episodes.view.observation[0, agent].tolist()
    assert len(row) == 10
    return row[:3], row[3:]


def test_the_own_way_leads_on_behind_a_robot() -> None:
    walls = [{"shape": {"name": "linestring", "vertices": [[1, y], [9, y]]}} for y in (4.6, 5.4)]
    walls += [{"shape": {"name": "linestring", "vertices": [[1, 4.6], [1, 5.4]]}}]
    robots = [robot(2, 5, (8, 5)), robot(4, 5, (8, 8))]
    task = {"name": "blank", "observations": ["way_on_seen_map", "shared_ways"], **WAITS}
    row = play(robots, walls, task, team=True).view.observation[0, 0]
    assert row[2] == 1.0  # there is no way past the other robot
    assert row[3:6].tolist() == pytest.approx([1, 0, 6 / DIAGONAL], abs=1e-6)
    # An obstacle in the same place is no robot.
    row = play(robots[0], [*walls, {**BALL, "shape": {"name": "circle", "radius": 0.2}, "state": [4, 5]}], task)
    assert row.view.observation[0, 0, [2, 5]].tolist() == [1.0, 1.0]


def test_the_way_of_another_that_leads_past_is_told_in_the_own_frame() -> None:
    heading = 0.5
    episodes = team([robot(5, 5, (5, 9), heading), robot(2, 5.3, (9, 5.3))])
    is_there, along, cosine, sine, x, y, length = seen(episodes, 0)[1]
    assert is_there == 1.0
    assert along == pytest.approx(3 / 4, abs=CELL / 4)
    assert [cosine, sine] == pytest.approx([np.cos(heading), -np.sin(heading)])
    # The nearest of the points, which lie a cell apart.
    ahead, left = 0.9 * np.array([x, y])
    place = [5 + ahead * np.cos(heading) - left * np.sin(heading), 5 + ahead * np.sin(heading) + left * np.cos(heading)]
    assert place == pytest.approx([5, 5.3], abs=CELL / 2 + 1e-6)
    assert place[1] == pytest.approx(5.3, abs=1e-6)
    assert length == pytest.approx(7 / DIAGONAL)
    assert seen(episodes, 1)[1] == [0.0] * 7  # the way up leads away from it: its nearest point is 3 m away


@pytest.mark.parametrize(("options", "is_there"), [({}, 1.0), ({"width": 0.25}, 0.0), ({"ahead": 1.5}, 0.0)])
def test_ways_that_are_far_or_lead_past_late_are_left_out(options: Any, is_there: float) -> None:
    episodes = team([robot(5, 5, (5, 9)), robot(2, 5.3, (9, 5.3))], **options)
    assert seen(episodes, 0)[1][0] == is_there


def test_of_several_ways_the_one_that_leads_past_soonest_is_told() -> None:
    others = [robot(2, 5.3, (9, 5.3)), robot(5.2, 3, (5.2, 8), 1.5), robot(8.5, 5.2, (1, 5.2), 3.1)]
    episodes = team([robot(5, 5, (5, 9)), *others])
    told = seen(episodes, 0)[1]
    assert told[1] == pytest.approx(2 / 4, abs=CELL / 4)
    assert told[2:4] == pytest.approx([0, 1], abs=1e-6)
    assert told[6] == pytest.approx(5 / DIAGONAL)


def test_a_way_around_a_wall_is_told_where_it_leads_past() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[5, 2], [5, 7]]}}
    episodes = team([robot(5, 7.6, (9, 9)), robot(3, 5, (7, 5))], [wall])
    is_there, along, cosine, _, _, y, length = seen(episodes, 0)[1]
    assert is_there == 1.0
    assert cosine > 0.9
    assert y < 0.0
    assert 0.25 * np.hypot(2, 2) < along < 1.0
    assert 2 * np.hypot(2, 2.2) / DIAGONAL < length < 2 * (2 + 2.6) / DIAGONAL


def test_a_robot_that_has_arrived_has_no_way() -> None:
    episodes = team([robot(5, 5, (5, 9)), robot(4.4, 5.2, (4.85, 5.2))])
    assert seen(episodes, 0)[1][0] == 1.0
    for _ in range(2):
        episodes.step(np.array([[[-1.0, 0.0], [1.0, 0.0]]]))
    assert episodes.state.arrival[0].tolist() == [0, 2]
    assert seen(episodes, 0)[1] == [0.0] * 7


def test_the_nearest_point_is_that_of_all_points_up_to_a_length() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        points, (x, y) = np.cumsum(rng.normal(0, 0.3, (20, 2)), axis=0), rng.normal(0, 1, 2)
        ahead = rng.uniform(0.5, 6)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        squared = np.where(along <= ahead, ((points - [x, y]) ** 2).sum(axis=1), np.inf)
        at = int(np.argmin(squared))
        assert nearest_point(points, x, y, ahead) == pytest.approx((at, along[at], squared[at]))


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


def test_a_team_in_a_mirror_observes_the_mirrored_columns() -> None:
    wall = {"shape": {"name": "rectangle", "length": 0.9, "width": 2.2}, "state": [5.03, 5.61, 0.3]}
    robots = [robot(4.02, 4.46, (9, 8.9), 0.4), robot(3.01, 5.13, (7.3, 5.2), -0.3)]
    upright, mirrored = (team([flipped(one, flip) for one in robots], [flipped(wall, flip)]) for flip in (False, True))
    term = upright.terms["observations"][0]
    exchanged = term.options.mirrored(term)
    there = mirrored.view.observation[0][:, exchanged.columns] * exchanged.signs
    np.testing.assert_allclose(upright.view.observation[0], there, atol=2 * CELL)
    assert upright.view.observation[0, 0, 3] == 1.0


def flipped(body: dict[str, Any], flip: bool) -> dict[str, Any]:
    """Return a body whose upper and lower sides are exchanged."""
    keys = [key for key in ("state", "goal") if key in body and flip]
    return {**body, **{key: [body[key][0], 10 - body[key][1], -body[key][2]] for key in keys}}
