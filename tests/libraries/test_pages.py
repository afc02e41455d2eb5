"""What the pages of docs/libraries show is run, as scripts."""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version

import library_pages as pages
import pytest

PACKAGES = {"sbx": "sbx-rl", "sample_factory": "sample-factory", "pufferlib": "pufferlib-core", "own_loops": "torch"}
"""Packages that are not named as their module."""
GIVEN = {"rl_zoo3": ["--help"], "sample_factory": ["--env=empty_goal", "--help"]}
"""Arguments of scripts that train, which their own tests do."""


@pytest.mark.parametrize("name", pages.names())
def test_blocks_run(name, tmp_path):
    try:
        here = version(PACKAGES.get(name, name))
    except PackageNotFoundError:
        pytest.skip(f"{name} is not installed")
    told = pages.HEAD.match(pages.text_of(name))[2]
    if told and here != told:
        pytest.skip(f"{name} {here} is here, the page is about {told}")
    blocks = pages.blocks(name)
    assert blocks
    for k, block in enumerate(blocks):
        script = tmp_path / f"block_{k}.py"
        script.write_text(block, encoding="utf-8")
        command = [sys.executable, str(script), *GIVEN.get(name, [])]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, f"{done.stdout}\n{done.stderr}"
