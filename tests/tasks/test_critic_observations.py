"""What a critic sees that the actor does not: its numbers, and that nobody else is shown them."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import irsim_gym
from irsim_gym import sb3
from irsim_gym.errors import ScenarioError

SHOWN: list[Any] = [
    "route",
    {"name": "nearest_bodies", "count": 1, "code": "linear", "range": 10.0},
]
OBSERVED = ["goal"]
PLACES = ([2, 5, 0], [2.05, 5]), ([2, 8, 0], [9, 8])


def world(critic: list[Any], **task: Any) -> dict[str, Any]:
    """Return a robot at (2, 5) that looks along x, its goal 6 m ahead, and a box of 1 m from (3, 5.5) to (4, 6.5)."""
    return {
        "world": {"width": 10, "height": 10},
        "robot": {
            "kinematics": {"name": "diff"},
            "state": [2, 5, 0],
            "goal": [8, 5],
            "shape": {"name": "circle", "radius": 0.2},
            "sensors": [{"name": "lidar2d", "number": 4}],
        },
        "obstacle": {"shape": {"name": "rectangle", "length": 1.0, "width": 1.0}, "state": [3.5, 6.0, 0]},
        "task": {
            "name": "blank",
            "observations": OBSERVED,
            "critic_observations": critic,
            "rewards": ["arrival"],
            "endings": ["arrived"],
            **task,
        },
    }


def test_the_numbers_of_the_critic_are_those_worked_out_by_hand() -> None:
    env = sb3.make_vec_env(world(SHOWN), 1, seed=0, critic=True)
    seen = env.reset()
    assert list(seen) == ["vector", "critic"]
    length = seen["critic"][0, :3]
    np.testing.assert_allclose(length, [1.0, 0.0, 6.0 / np.hypot(10.0, 10.0)], atol=0.06)  # a point in a cell of 0.1 m
    assert seen["critic"].shape == (1, 3 + 5)
    assert env.observation_space["critic"].shape == seen["critic"].shape[1:]
    env.step(np.array([[1.0, 0.0]], np.float32))
    told = str(env.describe())
    assert "route" in told


def test_the_actor_sees_the_same_with_and_without_and_nobody_else_sees_more() -> None:
    task = {"critic_observations": SHOWN}
    both = sb3.make_vec_env("cluttered_room", 3, seed=5, task={"name": "navigation", **task}, critic=True)
    alone = sb3.make_vec_env("cluttered_room", 3, seed=5)
    single = irsim_gym.make("cluttered_room", task={"name": "navigation", **task})
    assert single.observation_space == alone.observation_space == both.observation_space["vector"]
    assert single.unwrapped.worlds.episodes.task.critic_observations == ()
    random = np.random.default_rng(2)
    np.testing.assert_array_equal(both.reset()["vector"], alone.reset())
    ended = 0
    for _ in range(120):
        actions = random.uniform(-1.0, 1.0, (3, 2)).astype(np.float32)
        seen, paid, dones, infos = both.step(actions)
        plain, plainly, plain_dones, plain_infos = alone.step(actions)
        np.testing.assert_array_equal(seen["vector"], plain)
        np.testing.assert_array_equal(paid, plainly)
        np.testing.assert_array_equal(dones, plain_dones)
        for info, other in zip(infos, plain_infos, strict=True):
            if info:
                ended += 1
                np.testing.assert_array_equal(info["terminal_observation"]["vector"], other["terminal_observation"])
                assert info["terminal_observation"]["critic"].shape == both.observation_space["critic"].shape
    assert ended
    again = pickle.loads(pickle.dumps(both))
    np.testing.assert_array_equal(again.step(actions)[0]["critic"], both.step(actions)[0]["critic"])


def test_pictures_of_the_critic_and_of_both() -> None:
    picture = {"name": "occupancy_image", "pixels": 36}
    env = sb3.make_vec_env(world([picture, "route"]), 2, critic=True)
    seen = env.reset()
    assert {name: part.shape for name, part in seen.items()} == {
        "vector": (2, 4), "critic": (2, 3), "critic_occupancy_image": (2, 36, 36, 2)
    }  # fmt: skip
    assert seen["critic_occupancy_image"].max() == 255
    both = sb3.make_vec_env(world([picture], observations=[picture]), 1, critic=True)
    assert list(both.reset()) == ["occupancy_image", "critic_occupancy_image"]


def test_robots_that_wait_keep_what_their_critic_saw_last() -> None:
    near, far = ({**world([])["robot"], "state": state, "goal": goal} for state, goal in PLACES)
    team = {**world(SHOWN), "robot": [near, far]}
    env = sb3.make_multi_agent_vec_env(team, 1, seed=0, critic=True)
    env.leaves_out_waiting = True
    env.reset()
    seen, _, dones, infos = env.step(np.zeros((2, 2), np.float32))
    assert dones.tolist() == [True, False]
    last = infos[0]["terminal_observation"]["critic"]
    after = env.step(np.ones((2, 2), np.float32))[0]["critic"]
    np.testing.assert_array_equal(after[0], last)
    assert (after[1] != seen["critic"][1]).any()


@pytest.mark.parametrize(
    ("task", "told"),
    [
        ({"critic_observations": ["rout"]}, r"critic_observations\[0\].*did you mean 'route'"),
        ({"critic_observations": [{"name": "route", "ahead": -1.0}]}, r"critic_observations\[0\].ahead.*> 0"),
        ({"critic_observations": ["route", "route"]}, r"critic_observations\[1\].*given twice"),
        ({"critic_observations": ["route"], "observation_form": "goal"}, "no observations of the critic alone"),
    ],
)
def test_mistakes_are_told_with_their_place(task: dict[str, Any], told: str) -> None:
    with pytest.raises(ScenarioError, match=told):
        irsim_gym.make(world([], **task))
