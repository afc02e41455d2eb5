"""``render_mode="human"``: a window that environments of all kinds keep up to date by themselves."""

from __future__ import annotations

import copy
import gc
import os
import pickle
import subprocess
import sys
import time
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import render_test
from pettingzoo.utils.conversions import parallel_to_aec
from screen import Screen

import irsim_gym
from irsim_gym import sb3
from irsim_gym.errors import NoWindowError

SMALL = {"plot": {"figure_pixels": [240, 200]}, "step_time": 0.05, "sample_time": 0.1}
ROBOT = {"kinematics": {"name": "diff"}, "state": [1, 5, 0], "goal": [9, 5, 0]}
ONE = {"world": {"name": "one_robot", **SMALL}, "robot": ROBOT}
TEAM = {"world": {"name": "a_team", **SMALL}, "robot": {**ROBOT, "number": 3, "state": [[1, 2], [1, 5], [1, 8]]}}
AHEAD = np.array([0.5, 0.0], np.float32)


def shown_by(env: object) -> np.ndarray:
    """Return what an environment of the same scenario draws at the same moment."""
    return np.asarray(env.unwrapped.worlds.pictures.now(0))  # type: ignore[attr-defined]


def test_the_window_follows_reset_and_samples(screen: Screen, kept_picture) -> None:
    env = irsim_gym.make(ONE, render_mode="human")
    assert env.metadata["render_fps"] == pytest.approx(10.0)
    assert not screen.has_window("one_robot")
    env.reset(seed=0)
    first = screen.picture(240, 200)
    assert np.array_equal(first, shown_by(env))
    env.step(AHEAD)
    assert np.array_equal(screen.picture(240, 200), first)  # half way to the next sample
    env.step(AHEAD)
    kept_picture(screen.picture())
    assert np.array_equal(screen.picture(240, 200), shown_by(env))
    assert not np.array_equal(first, shown_by(env))
    assert env.render() is None
    env.close()
    assert not screen.has_window("one_robot")
    env.close()


def test_the_window_keeps_to_real_time(display: str) -> None:
    env = irsim_gym.make(ONE, render_mode="human")
    env.reset(seed=0)
    begin = time.perf_counter()
    for _ in range(12):
        env.step(AHEAD)
    took = time.perf_counter() - begin
    assert 0.6 - 0.01 <= took < 1.2
    time.sleep(0.2)  # whoever thinks for longer than a sample does not wait besides
    begin = time.perf_counter()
    env.step(AHEAD)
    env.step(AHEAD)
    assert time.perf_counter() - begin < 0.08
    env.close()


def test_a_person_may_close_the_window(screen: Screen, until) -> None:
    env = irsim_gym.make(ONE, render_mode="human")
    env.reset(seed=0)
    screen.close_window("one_robot")
    with pytest.warns(UserWarning, match="the window was closed: the environment goes on without one"):
        until(lambda: env.render() is None and not screen.has_window("one_robot"))
    begin = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(40):
            observation, *_ = env.step(AHEAD)
        env.reset(seed=1)
    assert time.perf_counter() - begin < 1.0  # two seconds in the world: nobody has to wait for a window
    assert observation.shape == env.observation_space.shape
    assert not screen.has_window("one_robot")
    env.close()


def test_a_forgotten_environment_takes_its_window_along(screen: Screen) -> None:
    env = irsim_gym.make(ONE, render_mode="human")
    env.reset(seed=0)
    assert screen.has_window("one_robot")
    del env
    gc.collect()
    assert not screen.has_window("one_robot")


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_open_windows_of_their_own(screen: Screen, copied) -> None:
    env = irsim_gym.make(ONE, render_mode="human").unwrapped
    env.reset(seed=0)
    other = copied(env)
    env.close()
    assert not screen.has_window("one_robot")
    for _ in range(2):
        other.step(AHEAD)
    assert np.array_equal(screen.picture(240, 200), shown_by(other))
    other.close()
    assert not screen.has_window("one_robot")


def test_a_forked_process_leaves_the_window_alone(screen: Screen) -> None:
    env = irsim_gym.make(ONE, render_mode="human")
    env.reset(seed=0)
    before = screen.picture(240, 200)
    child = os.fork()
    if child == 0:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            for _ in range(4):
                env.step(AHEAD)
            env.close()
        other = irsim_gym.make(ONE, render_mode="human")
        try:
            other.reset(seed=0)
        except NoWindowError as error:
            told = "Start processes with 'spawn'" in str(error)
        os._exit(0 if told and ["parent" in str(one.message) for one in caught] == [True] else 1)
    assert os.waitpid(child, 0)[1] == 0
    assert np.array_equal(screen.picture(240, 200), before)
    for _ in range(2):
        env.step(AHEAD)
    assert np.array_equal(screen.picture(240, 200), shown_by(env))
    env.close()


def test_forked_workers_open_windows_of_their_own(display: str) -> None:
    script = f"""
import subprocess, gymnasium, irsim_gym
envs = gymnasium.make_vec("irsim_gym/World-v0", 2, vectorization_mode="async", vector_kwargs={{"context": "fork"}},
                          scenario={ONE!r}, render_mode="human")
envs.reset(seed=0)
envs.step(envs.action_space.sample())
found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", "one_robot"], capture_output=True, text=True)
print(len(found.stdout.split()), envs.render())
envs.close()
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=60)
    assert done.stdout.strip() == "2 (None, None)", done.stderr


def test_worlds_side_by_side(screen: Screen, kept_picture) -> None:
    envs = irsim_gym.make_vec(ONE, 4, render_mode="human", max_steps=2)
    envs.reset(seed=0)
    up_to_date = []
    for _ in range(4):
        envs.step(np.tile(AHEAD, (4, 1)))
        kept_picture(screen.picture())
        tiled = np.asarray(envs.tiled())
        assert tiled.shape == (400, 480, 3)
        up_to_date.append(np.array_equal(screen.picture(480, 400), tiled))
    assert up_to_date == [False, True, True, False]  # between samples, the end, the beginning, between samples
    assert envs.render() is None
    envs.close()
    assert not screen.has_window("one_robot")


@pytest.mark.parametrize("mode", ["human", "rgb_array"])
def test_stable_baselines_shows_its_worlds(screen: Screen, mode: str) -> None:
    env = sb3.make_vec_env(ONE, 2, seed=0, render_mode=mode)
    env.reset()
    for _ in range(2):
        env.step(np.tile(AHEAD, (2, 1)))
        env.render("human")
    images = env.get_images()
    assert np.array_equal(screen.picture(480, 200), np.hstack(images))
    env.close()
    assert not screen.has_window("one_robot")


def test_a_team_of_stable_baselines_shows_its_worlds(screen: Screen) -> None:
    env = sb3.make_multi_agent_vec_env(TEAM, 2, seed=0, render_mode="human")
    env.reset()
    env.step(np.tile(AHEAD, (6, 1)))
    env.step(np.tile(AHEAD, (6, 1)))
    assert np.array_equal(screen.picture(480, 200), np.hstack(env.get_images()))
    env.close()


def test_pettingzoos_render_test(screen: Screen) -> None:
    def make(render_mode: str | None = None):
        return parallel_to_aec(irsim_gym.parallel_env(TEAM, render_mode=render_mode))

    render_test(make, custom_tests={"rgb_array_list": lambda frames: all(frame.ndim == 3 for frame in frames)})
    assert not screen.has_window("a_team")


def test_gymnasiums_checker_renders_in_all_modes(screen: Screen) -> None:
    gymnasium.register("own/one-v0", "irsim_gym.envs.gymnasium.single:WorldEnv", kwargs={"scenario": ONE})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make("own/one-v0").unwrapped)
    del gymnasium.registry["own/one-v0"]
    assert not screen.has_window("one_robot")
