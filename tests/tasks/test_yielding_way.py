"""The observation yielding_way: robots that know each other's ways, and stand aside for each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import BALL, ROBOT, drive, play

from irsim_gym.tasks import Episodes

DIAGONAL = np.hypot(10, 10)
WAITS: dict[str, Any] = {"endings": [{"name": "arrived", "wait": True}]}
CELL = 10 / 64
WIDTH = 0.8
STAY = [1.0, 0.0, 0.0]


def robot(x: float, y: float, goal: tuple[float, float], heading: float = 0.0, **more: Any) -> dict[str, Any]:
    return {**ROBOT, "state": [x, y, heading], "goal": [*goal, 0], **more}


def line(*vertices: tuple[float, float]) -> dict[str, Any]:
    return {"shape": {"name": "linestring", "vertices": [list(vertex) for vertex in vertices]}}


def team(robots: list[dict[str, Any]], obstacle: Any = None, **options: Any) -> Episodes:
    """Return a team that observes its yielding ways alone."""
    task = {"name": "blank", "observations": [{"name": "yielding_way", **options}], **WAITS}
    return play(robots, obstacle, task, team=True)


def seen(episodes: Episodes, agent: int) -> tuple[float, float, float]:
    """Return the direction, relative to the heading [rad], and the length [m] of an agent's way."""
    cosine, sine, length = episodes.view.observation[0, agent].tolist()
    assert np.hypot(cosine, sine) == pytest.approx(1.0, abs=1e-6)
    return cosine, sine, length * DIAGONAL


def arrived_at_once(x: float, y: float, heading: float = 0.0) -> dict[str, Any]:
    return robot(x, y, (x + 0.1, y), heading)


def stand(episodes: Episodes) -> Episodes:
    """Return the episodes after a step in which nobody moves."""
    drive(episodes, -1, 0)
    return episodes


def test_on_the_way_it_leads_on_behind_a_robot_but_not_behind_an_obstacle() -> None:
    walls = [line((1, 4.6), (9, 4.6)), line((1, 5.4), (9, 5.4)), line((1, 4.6), (1, 5.4))]
    task = {"name": "blank", "observations": ["yielding_way", "way_on_seen_map"], **WAITS}
    row = play([robot(2, 5, (8, 5)), robot(4, 5, (8, 8))], walls, task, team=True).view.observation[0, 0]
    assert row[:3].tolist() == pytest.approx([1, 0, 6 / DIAGONAL], abs=1e-6)
    assert row[5] == 1.0  # its own map knows no way past the other robot
    ball = {**BALL, "shape": {"name": "circle", "radius": 0.2}, "state": [4, 5]}
    blocked = play([robot(2, 5, (8, 5))], [*walls, ball], task, team=True).view.observation[0, 0]
    assert blocked[[2, 5]].tolist() == [1.0, 1.0]


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("heading", [0.0, 0.7])
def test_who_has_arrived_is_led_out_of_the_way_of_another(side: float, heading: float) -> None:
    beside = 0.3
    episodes = stand(team([arrived_at_once(5, 5, heading), robot(3, 5 + side * beside, (9, 5 + side * beside))]))
    assert episodes.state.arrival[0].tolist() == [1, 0]
    cosine, sine, length = seen(episodes, 0)
    # Away from the way: to the right of the heading 0 if the way is on the left.
    away = -side * np.pi / 2 - heading
    assert np.cos(away) * cosine + np.sin(away) * sine > 0.9
    assert WIDTH - beside - CELL < length < WIDTH - beside + 2 * CELL
    # The other one does not yield.
    assert seen(episodes, 1)[2] == pytest.approx(6, abs=1e-5)


def test_who_follows_the_way_aside_is_told_to_stay_when_it_is_there() -> None:
    episodes = stand(team([arrived_at_once(5, 5, -np.pi / 2), robot(2, 5.3, (9, 5.3))]))
    for _ in range(20):
        cosine, sine, length = seen(episodes, 0)
        if length == 0.0:
            break
        own = [1.0, np.clip(np.arctan2(sine, cosine), -1, 1)] if cosine > 0.9 else [-1.0, np.sign(sine)]
        episodes.step(np.array([[own, [-1.0, 0.0]]]))
    assert episodes.view.observation[0, 0].tolist() == STAY
    y = episodes.simulation.state.pose[0, 0, 1]
    assert WIDTH <= 5.3 - y < WIDTH + 2 * CELL


@pytest.mark.parametrize(
    ("other", "options"),
    [
        (robot(3, 5.9, (9, 5.9)), {}),  # far beside
        (robot(0.5, 5.7, (9, 5.7)), {}),  # not before 4 m of its way
        (robot(3, 5.3, (9, 5.3)), {"ahead": 1.0}),
        (robot(3, 5.5, (9, 5.5)), {"width": 0.45}),
        (robot(6, 5.9, (9, 5.3)), {}),  # past already
        (robot(3, 5.3, (3.2, 5.3)), {}),  # has arrived, too
    ],
)
def test_who_has_arrived_and_is_in_nobodys_way_stays(other: Any, options: Any) -> None:
    episodes = stand(team([arrived_at_once(5, 5), other], **options))
    assert episodes.view.observation[0, 0].tolist() == STAY


def test_of_two_that_meet_the_one_with_the_higher_number_yields() -> None:
    ahead, back = robot(3, 5, (9, 5)), robot(6, 5, (1, 5), np.pi)
    for robots, who in (([ahead, back], 1), ([back, ahead], 1)):
        episodes = team(robots)
        cosine, sine, length = seen(episodes, who)
        assert abs(sine) > 0.9
        assert WIDTH - CELL < length < WIDTH + 2 * CELL
        cosine, sine, length = seen(episodes, 1 - who)
        assert [cosine, sine] == pytest.approx([1, 0], abs=1e-6)
        assert length > 4.9


def test_who_stands_aside_waits_until_the_other_has_passed() -> None:
    """Robot 1 stands in a bay of a corridor and wants to go where robot 0 comes from."""
    walls = [line((1, 4.5), (9, 4.5)), line((1, 5.5), (4.4, 5.5), (4.4, 6.6), (5.6, 6.6), (5.6, 5.5), (9, 5.5))]
    waiting = robot(5, 6.1, (1.5, 5), -np.pi / 2)
    assert team([robot(2.5, 5, (8.5, 5)), waiting], walls).view.observation[0, 1].tolist() == STAY
    past = team([robot(6.5, 5, (8.5, 5)), waiting], walls)
    assert seen(past, 1)[2] > 3.5


def test_who_cannot_stand_aside_is_yielded_to() -> None:
    """Robot 1 wants out of a dead end into which robot 0 wants."""
    walls = [line((5, 4.6), (1, 4.6), (1, 5.4), (5, 5.4))]
    episodes = team([robot(3.6, 5, (1.5, 5), np.pi), robot(2.5, 5, (9, 5))], walls)
    cosine, sine, length = seen(episodes, 1)
    assert [cosine, sine, length] == pytest.approx([1, 0, 6.5], abs=1e-5)
    cosine, _, length = seen(episodes, 0)
    assert cosine < -0.7  # back out of the corridor
    assert 1.4 < length < 4


def test_who_has_arrived_where_there_is_no_way_aside_knows_it() -> None:
    walls = [line((9, 4.6), (1, 4.6), (1, 5.4), (9, 5.4))]
    episodes = stand(team([arrived_at_once(2, 5), robot(4, 5, (1.5, 5), np.pi)], walls))
    assert episodes.view.observation[0, 0].tolist() == [1.0, 0.0, 1.0]


def test_the_way_aside_leads_past_robots() -> None:
    """Robot 2 stands where the nearest place would be."""
    robots = [arrived_at_once(5, 5), robot(3, 5.2, (9, 5.2)), arrived_at_once(5, 4.4)]
    free, taken = stand(team(robots[:2])), stand(team(robots))
    assert seen(free, 0)[1] < -0.9
    assert seen(taken, 0)[1] > -0.8
    assert seen(taken, 0)[2] > seen(free, 0)[2] + 0.1


def test_a_team_in_a_mirror_observes_the_mirrored_columns() -> None:
    wall = {"shape": {"name": "rectangle", "length": 0.9, "width": 2.2}, "state": [5.03, 5.61, 0.3]}
    robots = [robot(4.02, 4.46, (9, 8.9), 0.4), robot(3.01, 5.13, (7.3, 5.2), -0.3), arrived_at_once(7.21, 4.3)]
    upright, mirrored = (
        stand(team([flipped(one, flip) for one in robots], [flipped(wall, flip)])) for flip in (False, True)
    )
    term = upright.terms["observations"][0]
    exchanged = term.options.mirrored(term)
    there = mirrored.view.observation[0][:, exchanged.columns] * exchanged.signs
    np.testing.assert_allclose(upright.view.observation[0], there, atol=2 * CELL)


def flipped(body: dict[str, Any], flip: bool) -> dict[str, Any]:
    """Return a body whose upper and lower sides are exchanged."""
    keys = [key for key in ("state", "goal") if key in body and flip]
    return {**body, **{key: [body[key][0], 10 - body[key][1], -body[key][2]] for key in keys}}


def test_threads_and_batches_change_nothing() -> None:
    robots = [arrived_at_once(5, 5), robot(3, 5.2, (9, 5.2)), robot(7, 5, (1, 5), np.pi), arrived_at_once(5, 4.4)]
    task = {"name": "blank", "observations": ["yielding_way"], **WAITS}
    one, many = play(robots, None, task, team=True), play(robots, None, task, 7, num_threads=2, team=True)
    rng = np.random.default_rng(0)
    for _ in range(30):
        action = rng.uniform(-1, 1, (1, 4, 2))
        one.step(action)
        many.step(np.repeat(action, 7, axis=0))
        np.testing.assert_array_equal(many.view.observation, np.repeat(one.view.observation, 7, axis=0))


@pytest.mark.parametrize("gone", [False, True])
def test_hits_are_those_of_robots_that_are_there(gone: bool) -> None:
    """A wall 0.25 m behind a robot: its hits beside the robot are left out of the map only while the robot is there."""
    episodes = team([robot(2, 5, (8, 5)), robot(4, 5, (4, 8))], line((4.25, 3), (4.25, 7)), every=1)
    simulation, arrays = episodes.simulation, episodes.terms["observations"][0].arrays
    if gone:
        flags = np.array([[False, True]])
        simulation.run(lambda shard: simulation.vanish(shard, simulation.agents, flags), np.array([0]))
    stand(episodes)
    assert arrays.ways.seen.skipped[0, 0].any() == (not gone)
