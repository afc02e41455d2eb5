"""A page of what an environment's robot did."""

from __future__ import annotations

from pathlib import Path

import gymnasium
import numpy as np
import pytest
from replay_pages import read_html, unpacked

import irsim_gym


def test_episodes_of_an_environment(tmp_path: Path) -> None:
    path = tmp_path / "run.html"
    env = irsim_gym.RecordReplay(gymnasium.make("irsim_gym/empty_goal-v0", max_steps=6), path, most=2)
    rewards: list[list[float]] = []
    for seed in (3, 4, 5):
        env.reset(seed=seed)
        rewards.append([0.0])
        over = False
        while not over:
            _, reward, terminated, truncated, _ = env.step(np.array([0.5, 0.1], np.float32))
            rewards[-1].append(float(reward))
            over = terminated or truncated
    assert not path.exists()
    env.close()
    env.close()
    episodes = read_html(path)["episodes"]
    assert [episode["name"] for episode in episodes] == ["level 4: timeout, 0.6 s", "level 5: timeout, 0.6 s"]
    for episode, paid in zip(episodes, rewards[1:], strict=True):
        (agent,) = episode["agents"]
        assert unpacked(agent["values"]["reward"], 7).ravel() == pytest.approx(paid, abs=1e-6)
        assert unpacked(agent["action"], 7)[1:] == pytest.approx(np.array([[0.5, 0.1]] * 6), abs=1e-3)


def test_a_page_without_an_episode_is_not_written(tmp_path: Path) -> None:
    env = irsim_gym.RecordReplay(irsim_gym.make("empty_goal"), tmp_path / "run.html")
    env.close()
    assert not list(tmp_path.iterdir())


def test_recording_changes_nothing() -> None:
    found = []
    for recorded in (False, True):
        env = irsim_gym.make("cluttered_room")
        env = irsim_gym.RecordReplay(env, "unused.html") if recorded else env
        rows = [env.reset(seed=1)[0]]
        rows += [env.step(np.array([0.4, 0.2], np.float32))[0] for _ in range(5)]
        found.append(np.array(rows))
    assert np.array_equal(*found)


def test_environments_of_others_are_refused() -> None:
    with pytest.raises(ValueError, match="of irsim_gym"):
        irsim_gym.RecordReplay(gymnasium.make("CartPole-v1"), "x.html")
    with pytest.raises(ValueError, match="most=0"):
        irsim_gym.RecordReplay(irsim_gym.make("empty_goal"), "x.html", most=0)
