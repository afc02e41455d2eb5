"""What docs/rllib.md shows is run."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from needed import library

PAGE = (Path(__file__).parents[2] / "docs" / "rllib.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module", autouse=True)
def ray():
    return library("ray")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def done(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0", "RAY_USAGE_STATS_ENABLED": "0"}
    found = subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True, timeout=600, check=False
    )
    assert found.returncode == 0, f"{found.stdout}\n{found.stderr}"
    return found


def test_the_block_runs(tmp_path):
    (block,) = blocks("python")
    script = tmp_path / "block.py"
    script.write_text(block, encoding="utf-8")
    assert done([str(script)], tmp_path).stdout.startswith("2048")


@pytest.mark.slow
def test_the_training_runs_for_a_while(tmp_path):
    (line,) = [one for block in blocks("bash") for one in block.splitlines() if one.startswith("irsim-gym train")]
    done(["-m", *line.replace("irsim-gym", "irsim_gym").split(), "--steps", "100", "--dev-levels", "4"], tmp_path)
    assert (tmp_path / "runs" / "cluttered_room-ppo-rllib-steps=100-0" / "policy.zip").is_file()


@pytest.mark.slow
def test_the_grid_runs_and_once_more_does_nothing(tmp_path):
    library("optuna")
    (text,) = blocks("yaml")
    (line,) = [one for block in blocks("bash") for one in block.splitlines() if one.startswith("irsim-gym tune")]
    (tmp_path / "grid.yaml").write_text(text, encoding="utf-8")
    words = ["-m", *line.replace("irsim-gym", "irsim_gym").split()]
    first = done(words, tmp_path)
    assert "8 trials, 8 of them to do" in first.stderr
    (table,) = (tmp_path / "runs").glob("*/trials.csv")
    assert len(table.read_text().splitlines()) == 9
    again = done(words, tmp_path)
    assert "8 trials, 0 of them to do" in again.stderr
    assert again.stdout == first.stdout
