"""Sample Factory: a short training by the script of its page."""

from __future__ import annotations

import subprocess
import sys

import library_pages as pages
from needed import library


def test_it_trains(tmp_path):
    library("sample_factory")
    (tmp_path / "train.py").write_text(pages.blocks("sample_factory")[0], encoding="utf-8")
    what = ["--env=empty_goal", "--algo=APPO", "--device=cpu", "--experiment=e", "--train_dir=runs"]
    size = ["--num_workers=1", "--num_envs_per_worker=2", "--rollout=16", "--batch_size=64"]
    how = ["--train_for_env_steps=128", "--serial_mode=True", "--async_rl=False", "--use_rnn=False"]
    here = ["--normalize_input=False", "--batched_sampling=True"]
    command = [sys.executable, "train.py", *what, *size, *how, *here]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
    assert list((tmp_path / "runs" / "e" / "checkpoint_p0").glob("*.pth"))
