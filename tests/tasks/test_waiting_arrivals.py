"""Robots that have arrived and drive on until their team has (``arrived`` with ``wait``)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import BALL, ROBOT, drive, play

import irsim_gym
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.policies.reference_policies import reference_policy
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.tasks import Episodes, Outcome

NEAR = {**ROBOT, "state": [2, 2, 0], "goal": [3.05, 2, 0]}
FAR = {**ROBOT, "state": [2, 8, 0], "goal": [5.05, 8, 0]}
WAITS = {"endings": [{"name": "arrived", "wait": True}]}


def team(robots: list[dict[str, Any]], obstacle: Any = None, **task: Any) -> Episodes:
    return play(robots, obstacle, {**WAITS, **task}, team=True)


def paid(episodes: Episodes, name: str) -> list[float]:
    terms: list[float] = episodes.view.reward_terms[0, :, episodes.reward_names.index(name)].tolist()
    return terms


def outcomes(episodes: Episodes) -> list[int]:
    found: list[int] = episodes.view.infos["outcome"][0].tolist()
    return found


def test_an_arrival_pays_at_once_and_the_episode_ends_with_the_last_one() -> None:
    episodes = team([NEAR, FAR])
    bonus = []
    for _ in range(28):
        drive(episodes, 1, 0)
        bonus.append(paid(episodes, "arrival"))
        if len(bonus) < 28:
            assert outcomes(episodes) == [Outcome.RUNNING, Outcome.RUNNING]
    assert [step for step, pay in enumerate(bonus, 1) if pay != [0.0, 0.0]] == [8, 28]
    assert [bonus[7], bonus[27]] == [[5.0, 0.0], [0.0, 5.0]]
    assert outcomes(episodes) == [Outcome.SUCCESS, Outcome.SUCCESS]
    assert episodes.view.terminated.all()
    assert not episodes.view.truncated.any()


def test_after_its_arrival_a_robot_drives_on_for_nothing() -> None:
    episodes = team([NEAR, FAR], observations=["has_arrived"])
    column = episodes.n_features - 1
    for step in range(1, 21):
        drive(episodes, 1, 0)
        assert episodes.state.observation[0, :, column].tolist() == [float(step >= 8), 0.0]
        if step > 8:
            assert episodes.view.reward[0, 0] == 0.0
            assert episodes.view.reward[0, 1] != 0.0
    assert episodes.simulation.state.pose[0, 0, 0] == pytest.approx(4.0)
    assert episodes.view.infos["path_length"][0].tolist() == pytest.approx([0.8, 2.0])


def test_a_robot_that_has_arrived_and_stands_elsewhere_is_not_deadlocked() -> None:
    episodes = team([NEAR, FAR], deadlock_time=0.3)
    for step in range(25):
        moves = np.array([[[1.0 if step < 15 else -1.0, 0.0], [1.0, 0.0]]])
        episodes.step(moves)
    assert not episodes.view.infos["deadlocked"].any()
    assert outcomes(episodes) == [Outcome.RUNNING, Outcome.RUNNING]


def test_a_collision_after_the_arrival_costs_its_penalty_and_leaves_the_success() -> None:
    episodes = team([NEAR, FAR], {**BALL, "state": [4.5, 2, 0]})
    for _ in range(18):
        drive(episodes, 1, 0)
    assert outcomes(episodes) == [Outcome.SUCCESS, Outcome.RUNNING]
    assert paid(episodes, "collision") == [-4.0, 0.0]
    assert episodes.view.infos["is_success"][0].tolist() == [True, False]
    drive(episodes, 1, 0)
    assert episodes.view.over[0].tolist() == [True, False]


def test_nobody_waits_for_a_robot_that_has_failed() -> None:
    episodes = team([NEAR, FAR], {**BALL, "state": [4.05, 8, 0]})
    while episodes.view.live[0].any():
        drive(episodes, 1, 0)
    assert outcomes(episodes) == [Outcome.SUCCESS, Outcome.COLLISION]
    assert episodes.view.infos["steps"][0].tolist() == [14, 14]


def test_the_time_limit_truncates_those_that_have_not_arrived() -> None:
    episodes = team([NEAR, FAR], max_steps=20)
    for _ in range(20):
        drive(episodes, 1, 0)
    assert outcomes(episodes) == [Outcome.SUCCESS, Outcome.TIMEOUT]
    assert episodes.view.terminated[0].tolist() == [True, False]
    assert episodes.view.truncated[0].tolist() == [False, True]


def test_a_collision_in_the_step_of_the_arrival_is_no_arrival() -> None:
    # The robot touches the ball 0.25 m before its goal, in the step in which it is within the threshold.
    robot = {**NEAR, "goal": [3.05, 2, 0]}
    episodes = team([robot, FAR], {**BALL, "state": [3.45, 2, 0]})
    for _ in range(8):
        drive(episodes, 1, 0)
    assert outcomes(episodes) == [Outcome.COLLISION, Outcome.RUNNING]
    assert (paid(episodes, "arrival"), paid(episodes, "collision")) == ([0.0, 0.0], [-4.0, 0.0])
    assert episodes.state.arrival[0].tolist() == [0, 0]


def test_nobody_waits_for_a_robot_that_is_deadlocked() -> None:
    endings = [{"name": "arrived", "wait": True}, "deadlocked"]
    episodes = team([NEAR, FAR], deadlock_time=1.0, endings=endings, rewards=[{"name": "deadlock", "weight": 4.0}])
    while episodes.view.live[0].any():
        episodes.step(np.array([[[1.0, 0.0], [-1.0, 0.0]]]))
    assert outcomes(episodes) == [Outcome.SUCCESS, Outcome.DEADLOCK]
    assert episodes.view.infos["steps"][0].tolist() == [10, 10]


def test_bodies_that_have_failed_vanish_and_those_that_wait_stay() -> None:
    episodes = team([NEAR, FAR, {**FAR, "state": [2, 5, 0]}], {**BALL, "state": [3, 5, 0]}, ended="vanish")
    for _ in range(12):
        drive(episodes, 1, 0)
    assert outcomes(episodes) == [Outcome.RUNNING, Outcome.RUNNING, Outcome.COLLISION]
    assert episodes.simulation.model.present[0, :3].tolist() == [True, True, False]


def test_agents_of_pettingzoo_stay_until_the_last_one_has_arrived() -> None:
    world = {"world": {"height": 10, "width": 10}, "robot": [NEAR, FAR], "task": {"name": "team_navigation", **WAITS}}
    env = irsim_gym.parallel_env(world)
    env.reset(seed=0)
    lengths = []
    while env.agents:
        lengths.append(len(env.agents))
        _, _, ended, _, infos = env.step({agent: np.array([1.0, 0.0], np.float32) for agent in env.agents})
    assert lengths == [2] * 28
    assert ended == {"robot_0": True, "robot_1": True}
    assert [infos[agent]["is_success"] for agent in infos] == [True, True]


def test_worlds_wait_alike_on_any_number_of_threads() -> None:
    runs = [play([NEAR, FAR], None, WAITS, 5, num_threads, team=True) for num_threads in (1, 2)]
    for _ in range(30):
        for episodes in runs:
            drive(episodes, 1, 0)
        np.testing.assert_array_equal(runs[0].view.reward, runs[1].view.reward)
    assert (runs[0].state.arrival == [8, 28]).all()
    assert (runs[1].state.arrival == [8, 28]).all()


def test_a_shared_reward_reaches_those_that_have_arrived() -> None:
    episodes = team([NEAR, FAR], team_reward=0.25)
    for _ in range(28):
        drive(episodes, 1, 0)
    assert paid(episodes, "arrival") == [0.625, 4.375]


def test_another_episode_begins_without_arrivals() -> None:
    episodes = team([NEAR, FAR])
    for _ in range(10):
        drive(episodes, 1, 0)
    assert episodes.state.arrival[0].tolist() == [8, 0]
    episodes.begin_next(np.arange(1))
    assert episodes.state.arrival[0].tolist() == [0, 0]


def test_a_single_robot_waits_for_nobody() -> None:
    one, other = (play({"goal": [3, 5, 0]}, None, task) for task in (WAITS, {}))
    while other.view.live[0].any():
        for episodes in (one, other):
            drive(episodes, 1, 0)
        np.testing.assert_array_equal(one.view.reward, other.view.reward)
    assert outcomes(one) == outcomes(other) == [Outcome.SUCCESS]


def test_times_and_paths_of_an_evaluation_end_with_the_arrival() -> None:
    (level,) = evaluate_team(reference_policy("dash"), team([NEAR, FAR]), 1)
    assert [row.episode.time for row in level.agents] == pytest.approx([0.8, 2.8])
    assert [row.episode.acceleration for row in level.agents] == pytest.approx([10.0 / 8, 10.0 / 28])
    assert [row.episode.path_length for row in level.agents] == pytest.approx([0.8, 2.8])


def test_robots_that_restart_one_by_one_cannot_wait() -> None:
    world = {"world": {"height": 10, "width": 10}, "robot": [NEAR, FAR], "task": {"name": "team_navigation", **WAITS}}
    with pytest.raises(IrsimGymError, match="omit respawn, or set wait: false"):
        irsim_gym.make_batch(world, 2, respawn=True)
