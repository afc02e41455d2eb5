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
    said = done([str(script)], tmp_path).stdout
    assert said.startswith("2048")
    assert " rllib " in said  # a row of the evaluation
