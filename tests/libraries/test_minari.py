"""Minari: demonstrations are written as datasets, and read again."""

from __future__ import annotations

import shutil
import subprocess
import sys

import library_pages as pages
import numpy as np
import pytest
from needed import library

import irsim_gym
from irsim_gym.scenario.specs.library import names

NAME = "irsim/shown-v0"
ABOUT = {"algorithm_name": "dash", "author": "me", "author_email": "me@example.org", "code_permalink": "none"}


@pytest.fixture
def minari(tmp_path, monkeypatch):
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "minari"))
    return library("minari")


def test_demonstrations_become_a_dataset_and_stay_the_same(minari, tmp_path):
    shown = irsim_gym.record_demonstrations("empty_goal", "dash", tmp_path / "demo.npz", levels=3)
    episodes = list(pages.shown("minari")["episodes_of"](shown))
    minari.create_dataset_from_buffers(NAME, episodes, env=irsim_gym.make("empty_goal"), **ABOUT)
    dataset = minari.load_dataset(NAME)
    assert (dataset.total_episodes, dataset.total_steps) == (3, len(shown))
    read = list(dataset.iterate_episodes())
    np.testing.assert_array_equal(np.concatenate([one.observations[:-1] for one in read]), shown.observations)
    np.testing.assert_array_equal([one.observations[-1] for one in read], shown.final_observations)
    for name in ("actions", "rewards", "terminations", "truncations"):
        np.testing.assert_array_equal(np.concatenate([getattr(one, name) for one in read]), getattr(shown, name))
    again = dataset.recover_environment()
    for one, level in zip(read, shown.levels.tolist(), strict=True):
        first, _ = again.reset(options={"split": "train", "level": level})
        np.testing.assert_array_equal(first, one.observations[0])
        np.testing.assert_allclose(again.step(one.actions[0])[0], one.observations[1], atol=1e-6)  # actions are float32


def test_its_collector_records_a_loop(minari):
    env = minari.DataCollector(irsim_gym.make("empty_goal", max_steps=5))
    for seed in range(2):
        env.reset(seed=seed)
        while not env.step(env.action_space.sample())[3]:
            pass
    dataset = env.create_dataset(NAME, **ABOUT)
    assert (dataset.total_episodes, dataset.total_steps) == (2, 10)
    assert next(dataset.iterate_episodes()).truncations.tolist() == [False] * 4 + [True]


def test_an_environment_is_made_again_by_its_path_without_an_import(minari, tmp_path):
    mine = tmp_path / "mine.yaml"
    shutil.copyfile(names()["empty_goal"], mine)
    env = minari.DataCollector(irsim_gym.make(mine, max_steps=1))
    env.reset(seed=0)
    env.step(env.action_space.sample())
    env.create_dataset(NAME, **ABOUT)
    code = (
        f"import minari; env = minari.load_dataset({NAME!r}).recover_environment(); env.reset(); print(env.spec.kwargs)"
    )
    again = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert again.returncode == 0, again.stderr
    assert str(mine) in again.stdout
