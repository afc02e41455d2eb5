"""A sweep that is interrupted as from a terminal goes on with the same command."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from needed import library
from test_rllib import LONGEST_S, family, waited_for

from irsim_gym.training.checkpoint_files import list_checkpoints

SWEEP = """
scenario: empty_goal
seeds: 3
steps: 24576
dev_levels: 4
hyperparameters: {n_envs: 8, n_steps: 64, batch_size: 64, n_epochs: 4, checkpoint_every: 2048}
"""


@pytest.fixture(scope="module", autouse=True)
def ray():
    return library("ray")


def started(folder: Path) -> subprocess.Popen[str]:
    words = [sys.executable, "-m", "irsim_gym", "sweep", "sweep.yaml", "--out", "sweep"]
    with (folder / "messages.txt").open("a") as messages:
        return subprocess.Popen(words, cwd=folder, start_new_session=True, text=True, stderr=messages)


def content(folder: Path) -> dict[str, tuple[bytes, int]]:
    """Return what is in the files of a folder, and when they were written."""
    files = [file for file in folder.rglob("*") if file.is_file()]
    return {str(file): (file.read_bytes(), file.stat().st_mtime_ns) for file in files}


@pytest.mark.slow
def test_an_interrupted_sweep_goes_on_and_leaves_finished_trainings_alone(tmp_path):
    (tmp_path / "sweep.yaml").write_text(SWEEP, encoding="utf-8")
    first, second, third = (tmp_path / "sweep" / "trials" / f"{number:04d}" for number in range(3))
    command = started(tmp_path)
    try:
        waited_for(lambda: len(list_checkpoints(second / "checkpoints")) > 0)
        os.killpg(command.pid, signal.SIGINT)
        assert command.wait(LONGEST_S) == 130
        waited_for(lambda: not family(command.pid))
        told = (tmp_path / "messages.txt").read_text()
        assert "stopped with 2 of 3 trainings to do; run the same command to continue" in told
        assert "Traceback" not in told
        finished, reached = content(first), list_checkpoints(second / "checkpoints")[-1].name
        assert (first / "result.json").is_file()
        assert not (second / "result.json").exists()
        assert not (third / "result.json").exists()
        lines = (second / "curve.csv").read_text().splitlines()
        command = started(tmp_path)
        assert command.wait(LONGEST_S) == 0
    finally:
        if command.poll() is None:
            os.killpg(command.pid, signal.SIGKILL)
    assert "sweep of 3 trainings, 2 of them to do" in (tmp_path / "messages.txt").read_text()
    assert content(first) == finished
    assert int(reached) < 24576
    assert (second / "curve.csv").read_text().splitlines()[: len(lines)] == lines
    with (tmp_path / "sweep" / "sweep.csv").open() as file:
        assert [(row["training"], row["steps"]) for row in csv.DictReader(file)] == [(n, "24576") for n in "012"]
    waited_for(lambda: not family(command.pid))
