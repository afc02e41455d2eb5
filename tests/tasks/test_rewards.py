"""Every reward term against a value worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import BALL, drive, play

from irsim_gym.tasks.rewards.collision import Collision

DIAGONAL = np.sqrt(200.0)


def term(episodes: Any, name: str) -> float:
    return float(episodes.view.reward_terms[0, 0, episodes.reward_names.index(name)])


def test_terms_are_the_sum() -> None:
    episodes = play(obstacle=BALL)
    assert episodes.reward_names == (
        "progress", "arrival", "collision", "left_world", "time", "clearance", "smoothness",
    )  # fmt: skip
    for _ in range(40):
        drive(episodes, 1, 0.1)
        assert episodes.view.reward[0, 0] == sum(episodes.view.reward_terms[0, 0].tolist())


def test_progress_pays_four_for_a_diagonal() -> None:
    episodes = play()
    drive(episodes, 1, 0)
    assert term(episodes, "progress") == pytest.approx(4 / DIAGONAL * 0.1)
    episodes = play({"state": [2, 5, np.pi]})
    drive(episodes, 1, 0)
    assert term(episodes, "progress") == pytest.approx(-4 / DIAGONAL * 0.1)


def test_progress_sums_to_the_difference_of_the_potential() -> None:
    episodes = play(obstacle=BALL)
    total, rng = 0.0, np.random.default_rng(0)
    start = episodes.view.infos["goal_distance"][0, 0]
    for _ in range(50):
        drive(episodes, *rng.uniform(-1, 1, 2))
        total += term(episodes, "progress")
    assert total == pytest.approx(4 / DIAGONAL * (start - episodes.view.infos["goal_distance"][0, 0]))


@pytest.mark.parametrize("potential", ["euclidean", "geodesic"])
def test_progress_over_two_goals_never_jumps(potential: str) -> None:
    task = {"rewards": [{"name": "progress", "potential": potential}]}
    episodes = play({"state": [2, 5, 0], "goal": [[[3, 5], [3, 9]]]}, task=task)
    gains = []
    for _ in range(12):
        drive(episodes, 1, 0)
        gains.append(term(episodes, "progress") * DIAGONAL / 4)
    # The first goal counts as reached 0.3 m before it, at x = 2.7 or a step later; then the second one is 4 m aside.
    assert gains[:7] == pytest.approx([0.1] * 7)
    assert max(map(abs, gains)) <= 0.1 + 1e-12


def test_geodesic_progress_pays_for_the_way_around_a_wall() -> None:
    # A wall from the lower edge up to y = 8 between start and goal: going up pays, going straight at it does not.
    wall = {"shape": {"name": "rectangle", "length": 0.2, "width": 8}, "state": [5, 4, 0]}
    task = {"rewards": [{"name": "progress", "potential": "geodesic"}]}
    start = {"state": [4, 3, np.pi / 2], "goal": [6, 3, 0]}
    episodes = play(start, wall, task)
    drive(episodes, 1, 0)
    assert term(episodes, "progress") == pytest.approx(4 / DIAGONAL * 0.1, rel=0.05)
    total, field = 0.0, play(start, wall, task)
    for _ in range(20):
        drive(field, 1, 0)
        total += term(field, "progress")
    assert total == pytest.approx(4 / DIAGONAL * 2.0, rel=0.05)
    straight = play(start, wall)
    drive(straight, 1, 0)
    assert abs(term(straight, "progress")) < 0.01


def test_geodesic_and_euclidean_agree_in_the_open() -> None:
    task = {"rewards": [{"name": "progress", "potential": "geodesic"}]}
    episodes = play(task=task)
    total = 0.0
    for _ in range(30):
        drive(episodes, 1, 0)
        total += term(episodes, "progress")
    assert total == pytest.approx(4 / DIAGONAL * 3.0, rel=0.03)


def test_arrival_pays_once() -> None:
    episodes = play({"state": [7.55, 5, 0]})
    drive(episodes, 1, 0)
    assert term(episodes, "arrival") == 0.0
    drive(episodes, 1, 0)
    assert term(episodes, "arrival") == 5.0
    assert episodes.view.infos["is_success"][0, 0]
    drive(episodes, 1, 0)
    assert episodes.view.reward_terms[0, 0].tolist() == [0.0] * 7


def test_the_cheapest_collision() -> None:
    assert Collision(weight=4.0).least() == 4.0
    assert Collision(weight=4.0, robot=2.0, map=3.0).least() == 2.0
    assert Collision(weight=4.0, robot=2.0, map=3.0).least(["obstacle", "map"]) == 3.0
    assert Collision(weight=4.0, robot=2.0, obstacle=5.0).least(["moving_obstacle", "obstacle"]) == 5.0


def test_collision_costs_in_the_step_in_which_it_begins() -> None:
    task = {"endings": [{"name": "collided", "use": False}], "audit": False}
    episodes = play({"state": [4.25, 5, 0]}, BALL, task, collision_mode="unobstructed")
    paid = []
    for _ in range(3):
        drive(episodes, 1, 0)
        paid.append(term(episodes, "collision"))
    assert paid == [-4.0, 0.0, 0.0]
    episodes.begin(np.array([0]), np.array([0]))
    drive(episodes, 1, 0)
    assert term(episodes, "collision") == -4.0


def test_leaving_the_world_costs() -> None:
    episodes = play({"state": [10.15, 5, 0]})
    drive(episodes, 1, 0)
    assert term(episodes, "left_world") == -4.0


def test_time_costs_two_over_a_full_episode() -> None:
    episodes = play(task={"max_steps": 40})
    total = 0.0
    for _ in range(40):
        drive(episodes, -1, 1)
        total += term(episodes, "time")
    assert total == pytest.approx(-2.0)
    assert episodes.view.truncated[0, 0]


def test_closeness_costs_by_the_square_of_what_is_missing() -> None:
    # After the step the robot is at x = 4.2: 0.1 m from the ball's surface, a third of what is safe.
    episodes = play({"state": [4.1, 5, 0]}, BALL)
    drive(episodes, 1, 0)
    assert term(episodes, "clearance") == pytest.approx(-0.8 / 300 * (2 / 3) ** 2)
    far = play({"state": [2, 5, 0]}, BALL)
    drive(far, 1, 0)
    assert term(far, "clearance") == 0.0
    alone = play()
    drive(alone, 1, 0)
    assert term(alone, "clearance") == 0.0


def test_abrupt_actions_cost() -> None:
    episodes = play()
    drive(episodes, 1, 1)  # from rest, which is (-1, 0)
    assert term(episodes, "smoothness") == pytest.approx(-0.2 / 300 * (4 + 1) / 8)
    drive(episodes, -1, -1)
    assert term(episodes, "smoothness") == pytest.approx(-0.2 / 300)
    drive(episodes, -1, -1)
    assert term(episodes, "smoothness") == 0.0


def test_only_progress_and_arrival_are_ever_positive_and_running_costs_stay_below_a_collision() -> None:
    episodes = play({"distribution": {"name": "random"}}, {**BALL, "state": [5, 5, 0]}, n_worlds=32)
    positive = [name in ("progress", "arrival") for name in episodes.reward_names]
    running = [name in ("time", "clearance", "smoothness") for name in episodes.reward_names]
    rng, costs = np.random.default_rng(1), np.zeros((32, 1))
    for _ in range(300):
        episodes.step(rng.uniform(-1, 1, (32, 1, 2)))
        terms = episodes.view.reward_terms
        assert (terms[:, :, np.invert(positive)] <= 0).all()
        costs += terms[:, :, running].sum(axis=2)
    assert costs.min() > -3.0
