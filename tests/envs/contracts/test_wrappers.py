"""Gymnasium's wrappers around single and batched environments."""

from __future__ import annotations

import gymnasium
import imageio.v2 as imageio
import numpy as np
import pytest
from contract_tools import STILL
from gymnasium import wrappers
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers import vector as vector_wrappers


def test_single_wrappers():
    env = gymnasium.make(STILL, max_episode_steps=12, render_mode="rgb_array")
    env = wrappers.RecordEpisodeStatistics(env)
    env = wrappers.NormalizeReward(wrappers.NormalizeObservation(wrappers.ClipAction(env)))
    env = wrappers.FrameStackObservation(wrappers.TimeAwareObservation(env), 3)
    env.reset(seed=0)
    for _ in range(30):
        observation, _, terminated, truncated, info = env.step(env.action_space.sample())
        assert np.isfinite(observation).all()
        if terminated or truncated:
            assert info["episode"]["l"] == info["steps"]
            env.reset()


def test_flattened_dict_observations():
    env = gymnasium.make(STILL, task={"name": "navigation", "observation_form": "dict"})
    flat = wrappers.FlattenObservation(env)
    assert flat.reset(seed=0)[0] in flat.observation_space


def test_outer_time_limit():
    env = gymnasium.make(STILL, max_episode_steps=5, max_steps=50)
    env.reset(seed=0)
    assert [env.step(np.zeros(2, np.float32))[3] for _ in range(5)] == [False] * 4 + [True]


def observation_wrappers(env):
    yield vector_wrappers.NormalizeObservation(env)
    yield vector_wrappers.TransformObservation(env, lambda x: x * 0.5, single_observation_space=None)
    yield vector_wrappers.RescaleObservation(env, np.float32(0.0), np.float32(1.0))
    yield vector_wrappers.FlattenObservation(env)
    yield vector_wrappers.ReshapeObservation(env, (*env.single_observation_space.shape, 1))


def other_wrappers(env):
    yield vector_wrappers.RecordEpisodeStatistics(env)
    yield vector_wrappers.DictInfoToList(env)
    yield vector_wrappers.NormalizeReward(env)
    yield vector_wrappers.ClipReward(env, -1.0, 1.0)
    yield vector_wrappers.TransformAction(env, lambda x: x * 0.5)
    yield vector_wrappers.ClipAction(env)
    yield vector_wrappers.RescaleAction(env, np.float32(0.0), np.float32(1.0))


def exercise(env, n_steps=30):
    """Some steps with restarts."""
    env.reset(seed=0)
    for _ in range(n_steps):
        result = env.step(np.zeros((3, 2), np.float32))
        assert len(result) == 5
    env.reset()


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_vector_wrappers(mode):
    envs = gymnasium.make_vec(STILL, num_envs=3, max_steps=8, autoreset_mode=mode)
    for wrapped in other_wrappers(envs):
        exercise(wrapped)
    if mode is AutoresetMode.NEXT_STEP:
        for wrapped in observation_wrappers(envs):
            exercise(wrapped)


def test_vector_statistics():
    envs = vector_wrappers.RecordEpisodeStatistics(gymnasium.make_vec(STILL, num_envs=2, max_steps=4))
    envs.reset(seed=0)
    for _ in range(4):
        *_, infos = envs.step(np.zeros((2, 2), np.float32))
    assert infos["episode"]["l"].tolist() == [4, 4]
    assert infos["steps"].tolist() == [4, 4]


def test_statistics_survive_a_partial_reset():
    envs = gymnasium.make_vec(STILL, num_envs=3, autoreset_mode="Disabled")
    wrapped = vector_wrappers.RecordEpisodeStatistics(envs)
    wrapped.reset(seed=0)
    for _ in range(5):
        wrapped.step(np.zeros((3, 2), np.float32))
    wrapped.reset(options={"reset_mask": np.array([True, False, False])})
    assert wrapped.episode_lengths.tolist() == [0, 5, 5]


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore:unclosed:ResourceWarning")
def test_videos(tmp_path):
    env = gymnasium.make(STILL, max_steps=6, render_mode="rgb_array")
    env = wrappers.RecordVideo(env, str(tmp_path / "single"), episode_trigger=lambda k: k == 0, disable_logger=True)
    env.reset(seed=0)
    for _ in range(6):
        env.step(np.array([0.2, 0.0], np.float32))
    env.reset()
    env.close()
    assert [file.suffix for file in (tmp_path / "single").iterdir()] == [".mp4"]

    envs = gymnasium.make_vec(STILL, num_envs=2, max_steps=6, render_mode="rgb_array")
    envs = vector_wrappers.RecordVideo(envs, str(tmp_path / "many"), video_length=5, step_trigger=lambda k: k == 0)
    envs.reset(seed=0)
    for _ in range(8):
        envs.step(np.zeros((2, 2), np.float32))
    envs.close()
    (film,) = (tmp_path / "many").iterdir()
    with imageio.get_reader(film) as reader:
        assert reader.count_frames() == 1 + 5  # that of the reset is not counted in the length
        assert reader.get_data(0).shape == (600, 1200, 3)
