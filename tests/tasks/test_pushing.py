"""Observations, rewards and the ending of bodies that are pushed, against values worked out by hand.

The robot begins at x = 1, gains 0.4905 m/s a step (friction 0.5, 9.81 m/s2), and drives at 1 m/s from its third step
on. It reaches the box in its ninth step and pushes it on at 1 m/s: after step k > 9 the box lies at 2.647151 + 0.1 (k -
10) m. The friction of the box is 0.5 * 0.5 kg * 9.81 m/s2 = 2.4525 N.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from irsim_gym.errors import ScenarioError
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import Episodes, Outcome, load_task

ROBOT: dict[str, Any] = {
    "kinematics": {"name": "diff"},
    "shape": {"name": "circle", "radius": 0.3},
    "state": [1, 4, 0],
    "vel_min": [-1, -1],
    "vel_max": [1, 1],
}
BOX: dict[str, Any] = {
    "shape": {"name": "rectangle", "length": 0.8, "width": 0.8},
    "state": [2.5, 4, 0],
    "mass": 0.5,
    "goal": [3.6, 4, 0],
}
WORLD = {"name": "yard", "width": 12, "height": 5, "collision_mode": "contact"}
DIAGONAL, GRIP = 13.0, 2.4525
TOUCHING = 9
"""The step in which the robot touches the box first."""


def box_at(step: int) -> float:
    """Return where the box lies after a step in which it is pushed [m]."""
    return 2.647151 + 0.1 * (step - 10)


def play(robots: Any = ROBOT, boxes: Any = BOX, n_worlds: int = 1, threads: int = 1, **task: Any) -> Episodes:
    """Return the episodes of a task in a world of 12 by 5 m."""
    spec = load_scenario({"world": WORLD, "robot": robots, "obstacle": boxes})
    loaded = load_task(spec, {"name": "blank", "observations": ["velocity"], **task}, team=isinstance(robots, list))
    episodes = Episodes(compile(spec, n_worlds, agents=loaded.agents, num_threads=threads), loaded)
    episodes.begin(np.arange(n_worlds), np.arange(n_worlds))
    return episodes


def ahead(episodes: Episodes, steps: int = 1) -> None:
    """Drive all robots ahead at full speed."""
    for _ in range(steps):
        episodes.step(np.broadcast_to([1.0, 0.0], (episodes.n_worlds, episodes.n_agents, 2)))


def paid(episodes: Episodes, name: str) -> float:
    """Return what a reward has paid in the latest step."""
    return float(episodes.view.reward_terms[0, 0, episodes.reward_names.index(name)])


def test_a_movable_body_is_told_with_its_target() -> None:
    episodes = play(observations=[{"name": "movable_bodies", "count": 2, "range": 10.0}])
    first, second = episodes.view.observation[0, 0].reshape(2, 16)
    radius = 0.4 * np.sqrt(2.0)
    own = [1, 0, 0.15, np.exp(-1.5), 1, 0, 0, 0, radius / (radius + 0.5), 0.5 / 1.5, 1]
    np.testing.assert_allclose(first, [*own, 1, 0, 0.11, np.exp(-1.1), 0], atol=1e-6)
    assert not second.any()
    ahead(episodes, 5)
    # It has driven at 0.4905, 0.981 and then 1 m/s towards the box: relative to the robot, the box comes.
    np.testing.assert_allclose(episodes.view.observation[0, 0, [2, 6, 7]], [(1.5 - 0.44715) / 10, -0.5, 0], atol=1e-6)
    ahead(episodes, 14)
    # In step 19 it is 0.9 times 0.1 m nearer to its target than in step 10, and nearer than the threshold of 0.1 m.
    np.testing.assert_allclose(episodes.view.observation[0, 0, [13, 15]], [(3.6 - box_at(19)) / 10, 1.0], atol=1e-6)


def test_directions_are_in_the_frame_of_the_robot() -> None:
    robot = {**ROBOT, "state": [2.5, 2, np.pi / 2]}
    episodes = play(robot, observations=[{"name": "movable_bodies", "count": 1, "near": 0.5}])
    row = episodes.view.observation[0, 0]
    # The box stands ahead and is turned to the right; its target lies to the right of it.
    np.testing.assert_allclose(row[:6], [1, 0, 2 / DIAGONAL, np.exp(-4), 0, -1], atol=1e-6)
    np.testing.assert_allclose(row[11:], [0, -1, 1.1 / DIAGONAL, np.exp(-2.2), 0], atol=1e-6)


def test_bodies_in_their_targets_come_last_and_heavy_ones_are_told() -> None:
    boxes = {
        "number": 2,
        "shape": {"name": "rectangle", "length": 0.4, "width": 0.4},
        "state": [[2.0, 4, 0], [4.0, 4, 0]],
        "goal": [[2.0, 4, 0], [5.0, 4, 0]],
        "mass": [0.5, 3.0],
    }
    episodes = play(boxes=boxes, observations=[{"name": "movable_bodies", "count": 2}])
    rows = episodes.view.observation[0, 0].reshape(2, 16)
    np.testing.assert_allclose(rows[:, 2] * DIAGONAL, [3.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(rows[:, [9, 15]], [[3 / 4, 0], [0.5 / 1.5, 1]], atol=1e-6)
    untold = play(boxes=boxes, observations=[{"name": "movable_bodies", "count": 1, "range": 2.0, "target": False}])
    assert untold.view.observation.shape[2] == 11
    assert untold.view.observation[0, 0, 2] == pytest.approx(0.5)  # 1 m of 2 m: the other one is not seen


def test_contact_tells_force_and_time() -> None:
    episodes = play(boxes={**BOX, "goal": [9, 4, 0]}, observations=[{"name": "contact", "force": 5.0, "time": 2.0}])
    ahead(episodes, TOUCHING - 1)
    assert not episodes.view.observation.any()
    ahead(episodes, 20 - TOUCHING + 1)
    # Twelve steps in contact, the ninth to the twentieth.
    np.testing.assert_allclose(episodes.view.observation[0, 0], [-GRIP / 5, 0, 1, 1.2 / 2], atol=1e-5)
    for _ in range(4):
        episodes.step(np.array([[[-1.0, 0.0]]]))
    assert not episodes.view.observation.any()


def test_contact_is_told_in_the_frame_of_the_robot() -> None:
    box = {**BOX, "state": [2.5, 4.1, 0], "mass": 3.0}
    episodes = play({**ROBOT, "state": [2.5, 2.5, np.pi / 2]}, box, observations=["contact"])
    ahead(episodes, 20)
    # It cannot push the box: its drive presses as hard as it grips.
    np.testing.assert_allclose(episodes.view.observation[0, 0, :3], [-0.4905, 0, 1], atol=1e-6)


@pytest.mark.parametrize(("area", "gain"), [(None, 0.1), ([3.5, 3, 5, 5], 0.1), ([5.0, 3, 6, 5], 0.1)])
def test_progress_of_bodies_is_paid_by_the_way_gained(area: Any, gain: float) -> None:
    episodes = play(rewards=[{"name": "body_progress", "weight": 4.0, "area": area}])
    ahead(episodes, TOUCHING - 1)
    assert paid(episodes, "body_progress") == 0.0
    ahead(episodes, 3)
    assert paid(episodes, "body_progress") == pytest.approx(4 / DIAGONAL * gain)


def test_nothing_is_gained_within_an_area() -> None:
    episodes = play(rewards=[{"name": "body_progress", "weight": 1.0, "area": [3.5, 3, 5, 5]}])
    total = 0.0
    for _ in range(25):
        ahead(episodes)
        total += paid(episodes, "body_progress")
    assert box_at(25) > 3.5
    assert total == pytest.approx(1.0 / DIAGONAL)  # from 2.5 m to the edge of the area


def test_each_body_is_paid_for_once() -> None:
    area = [3.5, 3, 5, 5]
    boxes = {"number": 2, "shape": BOX["shape"], "state": [[2.5, 4, 0], [4.4, 2.6, 0]], "mass": 0.5}
    inside = {**boxes, "state": [[2.5, 4, 0], [4.4, 3.0, 0]]}
    for given in (boxes, inside):
        episodes = play(boxes=given, rewards=[{"name": "body_arrival", "weight": 2.0, "area": area}])
        pays = []
        for _ in range(19):
            ahead(episodes)
            pays.append(paid(episodes, "body_arrival"))
        # The box crosses the edge in step 19; one that lay in the area from the start is not paid for.
        assert pays == [0.0] * 18 + [2.0]
    ahead(episodes, 16)  # out of the area, through its far end
    assert box_at(35) > 5.0
    paid_again = paid(episodes, "body_arrival")
    assert paid_again == 0.0


def test_a_body_that_comes_back_is_not_paid_for_again() -> None:
    # The robot stands between the box and a wall of the area, which it pushes the box out of and then into again.
    episodes = play(boxes={**BOX, "state": [2.5, 4, 0]}, rewards=[{"name": "body_arrival", "area": [2.0, 3, 2.6, 5]}])
    assert paid(episodes, "body_arrival") == 0.0
    ahead(episodes, 12)
    state, pay = episodes.simulation.state, []
    for x in (2.9, 2.5, 2.9, 2.5):
        state.pose[0, 1, 0] = x
        episodes.step(np.array([[[-1.0, 0.0]]]))
        pay.append(paid(episodes, "body_arrival"))
    assert pay == [0.0] * 4


def test_effort_costs_power() -> None:
    rewards = [{"name": "push_effort", "weight": 0.5, "power": 5.0}]
    episodes = play(boxes={**BOX, "goal": [9, 4, 0]}, rewards=rewards, max_steps=100)
    ahead(episodes, TOUCHING - 1)
    assert paid(episodes, "push_effort") == 0.0
    ahead(episodes, 11)
    # 2.4525 N at 1 m/s are 2.4525 W, of 5 W.
    assert paid(episodes, "push_effort") == pytest.approx(-0.5 / 100 * GRIP / 5)
    stalled = play(boxes={**BOX, "mass": 3.0}, rewards=rewards)
    ahead(stalled, 20)
    assert paid(stalled, "push_effort") == 0.0  # it presses, and moves nothing


@pytest.mark.parametrize("area", [None, [3.5, 3, 5, 5]])
def test_an_episode_ends_with_the_arrival_of_the_body(area: Any) -> None:
    episodes = play(endings=[{"name": "bodies_arrived", "area": area}])
    ahead(episodes, 18)
    assert not episodes.view.terminated.any()
    ahead(episodes)
    assert episodes.view.terminated.all()
    assert episodes.view.infos["outcome"][0, 0] == Outcome.SUCCESS


def test_an_episode_goes_on_until_all_bodies_lie_in_their_targets() -> None:
    boxes = [BOX, {**BOX, "state": [9, 1, 0], "goal": [9, 1, 0], "name": "other"}]
    apart = [BOX, {**BOX, "state": [9, 1, 0], "goal": [9, 2, 0], "name": "other"}]
    for given, ends in ((boxes, True), (apart, False)):
        episodes = play(boxes=given, endings=["bodies_arrived"])
        ahead(episodes, 19)
        assert bool(episodes.view.terminated[0, 0]) == ends
    named = play(boxes=apart, endings=[{"name": "bodies_arrived", "bodies": ["other"]}])
    ahead(named, 19)
    assert not named.view.terminated.any()


def test_a_team_is_paid_and_ends_together() -> None:
    robots = [ROBOT, {**ROBOT, "state": [8, 1, 0]}]
    kinds = {"rewards": ["body_progress", "body_arrival"], "endings": ["bodies_arrived"]}
    episodes = play(robots, **kinds)
    ahead(episodes, 19)
    np.testing.assert_array_equal(episodes.view.reward_terms[0, 0], episodes.view.reward_terms[0, 1])
    assert episodes.view.reward_terms[0, 0, 1] == 1.0
    assert episodes.view.terminated.all()


EVERYTHING: dict[str, Any] = {
    "observations": [{"name": "movable_bodies", "count": 2}, "contact"],
    "rewards": ["body_progress", "body_arrival", "push_effort"],
    "endings": ["bodies_arrived"],
}


def test_batch_single_and_threads_agree() -> None:
    there = {"name": "random", "range_low": [1, 1, -3], "range_high": [3, 3, 3]}
    robot = {key: value for key, value in ROBOT.items() if key != "state"} | {"distribution": there}
    boxes = {"number_range": [1, 3], "shape": BOX["shape"], "mass": 0.5, "distribution": {**there, "min_distance": 0}}
    played = [play(robot, boxes, n, threads, **EVERYTHING) for n, threads in ((4, 1), (4, 3), (1, 1))]
    played[2].begin(np.array([0]), np.array([1]))
    rng, touched = np.random.default_rng(0), False
    for _ in range(150):
        actions = rng.uniform([0.5, -0.6], [1.0, 1.0], (4, 1, 2))
        for one in played:
            one.step(actions if one.n_worlds == 4 else actions[[1]])
        touched |= bool(played[0].view.reward_terms[1].any())
        for field in ("observation", "reward_terms", "terminated"):
            values = [getattr(one.view, field) for one in played]
            np.testing.assert_array_equal(values[0], values[1], err_msg=field)
            np.testing.assert_array_equal(values[0][1], values[2][0], err_msg=field)
        assert np.abs(played[0].view.observation).max() <= 1.0
    assert touched


@pytest.mark.parametrize(
    ("boxes", "kind", "said"),
    [
        (
            {**BOX, "mass": "inf"},
            {"name": "body_progress"},
            "there is no body that can be pushed: .* with a 'goal' unless",
        ),
        (BOX, {"name": "body_progress", "bodies": ["crate"]}, "'crate' is no body that can be pushed"),
        (BOX, {"name": "body_progress", "area": [2, 1, 1, 2]}, "'area' must be x0, y0, x1, y1 with x0 < x1"),
        (
            {**BOX, "goal": None},
            {"name": "body_progress"},
            "there is no body that can be pushed: .* with a 'goal' unless",
        ),
    ],
)
def test_what_cannot_be_pushed_is_refused(boxes: Any, kind: Any, said: str) -> None:
    with pytest.raises(ScenarioError, match=said):
        play(boxes={key: value for key, value in boxes.items() if value is not None}, rewards=[kind])


@pytest.mark.parametrize("family", ["observations", "rewards", "endings"])
def test_kinds_of_pushing_are_refused_where_nobody_pushes(family: str) -> None:
    spec = load_scenario({"world": {**WORLD, "collision_mode": "stop"}, "robot": ROBOT, "obstacle": BOX})
    for kind in EVERYTHING[family]:
        with pytest.raises(ScenarioError, match="collision_mode contact"):
            load_task(spec, {"name": "blank", "observations": ["velocity"], family: [kind]})
