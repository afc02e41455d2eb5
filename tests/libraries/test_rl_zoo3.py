"""rl_zoo3: its command, and the same with the native batch."""

from __future__ import annotations

import subprocess
import sys

import library_pages as pages
import numpy as np
import pytest
from needed import library

ID = "irsim_gym/empty_goal-v0"
SETTINGS = f"""
{ID}:
  policy: MlpPolicy
  n_envs: 4
  n_timesteps: 512
  n_steps: 64
  batch_size: 256
  n_epochs: 1
"""


@pytest.fixture(scope="module", autouse=True)
def zoo():
    return library("rl_zoo3")


@pytest.mark.parametrize("native", [False, True])
def test_it_trains(native, tmp_path):
    (tmp_path / "ppo.yml").write_text(SETTINGS, encoding="utf-8")
    (tmp_path / "zoo.py").write_text(pages.blocks("rl_zoo3")[0], encoding="utf-8")
    script = ["zoo.py"] if native else ["-m", "rl_zoo3.train"]
    what = ["--gym-packages", "irsim_gym", "--env", ID, "--algo", "ppo", "-conf", "ppo.yml", "--seed", "3"]
    how = ["-f", "logs", "--eval-freq", "256", "--eval-episodes", "2", "--device", "cpu"]
    limit = ["--env-kwargs", "max_steps:20"]
    command = [sys.executable, *script, *what, *how, *limit]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    folder = tmp_path / "logs" / "ppo" / "irsim_gym-empty_goal-v0_1"
    assert (folder / "irsim_gym-empty_goal-v0.zip").exists()
    assert np.load(folder / "evaluations.npz")["ep_lengths"].shape == (2, 2)
    for world in range(1 if native else 4):
        lines = (folder / f"{world}.monitor.csv").read_text().splitlines()[2:]
        assert len(lines) == 128 // 20 * (4 if native else 1)
        assert all(float(line.split(",")[1]) == 20 for line in lines)


def test_both_make_the_same_worlds(zoo):
    """The first observations agree, and so does what steps pay."""
    from stable_baselines3.common.env_util import make_vec_env

    native = pages.shown("rl_zoo3")["native"]
    mine, theirs = (make_vec_env(ID, n_envs=3, seed=5, vec_env_cls=cls) for cls in (native, None))
    np.testing.assert_array_equal(mine.reset(), theirs.reset())
    for _ in range(10):
        for one, other in zip(mine.step(np.ones((3, 2)))[:3], theirs.step(np.ones((3, 2)))[:3], strict=True):
            np.testing.assert_array_equal(one, other)
