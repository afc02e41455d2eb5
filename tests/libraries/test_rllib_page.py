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


def test_the_training_runs(tmp_path):
    said = done([script(0, tmp_path)], tmp_path).stdout
    assert int(float(said.split()[0])) >= 2048
    assert " rllib " in said  # a row of the evaluation


def test_the_team_trains(tmp_path):
    said = done([script(1, tmp_path)], tmp_path).stdout
    assert int(re.search(r"'shared': np.int64\((\d+)\)", said)[1]) >= 4 * 100  # four robots, which may wait


def script(number: int, folder: Path) -> str:
    file = folder / "block.py"
    file.write_text(blocks("python")[number], encoding="utf-8")
    return str(file)
