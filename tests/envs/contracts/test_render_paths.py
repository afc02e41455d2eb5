"""Environments note the paths that their pictures show, also where a picture is made only now and then."""

from __future__ import annotations

import numpy as np

import irsim_gym
from irsim_gym.envs.gymnasium.worlds import Worlds


def test_a_seldom_picture_shows_the_whole_path() -> None:
    seldom, often = (irsim_gym.make("cluttered_room", render_mode="rgb_array") for _ in range(2))
    for env, every in ((seldom, 20), (often, 1)):
        env.reset(seed=3)
        for step in range(20):
            env.step(np.array([0.3, 0.4]))
            if step % every == 0:
                env.render()
    assert np.array_equal(seldom.render(), often.render())
    seldom.reset(seed=3)
    often.reset(seed=3)
    assert np.array_equal(seldom.render(), often.render())


def test_paths_of_a_batch_end_with_their_episodes() -> None:
    worlds = Worlds("cluttered_room", 3, render_mode="rgb_array")
    worlds.begin(range(3), [0, 1, 2], [{}] * 3, lambda w: w)
    for _ in range(70):
        worlds.step(np.zeros((3, 1, 2)))
    worlds.begin_next(np.array([1]))
    worlds.step(np.zeros((3, 1, 2)), np.array([0, 1]))
    trails = worlds.pictures.trails
    assert trails is not None
    assert [len(trails.poses(w, 0)) for w in range(3)] == [72, 2, 71]
    assert np.array_equal(trails.poses(1, 0)[-1], worlds.simulation.state.pose[1, trails.bodies[0]])


def test_nothing_is_noted_without_a_render_mode() -> None:
    assert Worlds("cluttered_room").pictures.trails is None
