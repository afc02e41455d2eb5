"""What docs/to_your_robot.md shows is run."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import pytest
from command_line import run
from test_readme import ROOT, blocks, commands

from irsim_gym.robot import fitting as fit
from irsim_gym.robot.contract import Results

PAGE = ROOT / "docs" / "to_your_robot.md"


def test_the_page_works_as_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    solved = Results(success=1.0, low=0.98, high=1.0, levels=200, split="test")
    monkeypatch.setattr(fit, "results_of", lambda *played: solved)  # other tests play
    for command in commands(PAGE):
        if command.startswith("irsim-gym"):
            assert run(monkeypatch, *shlex.split(command, comments=True)[1:]) == 0
    assert Path("drive-check.png").is_file()
    for block in blocks(PAGE, "python"):
        exec(compile(block.text, str(block), "exec", dont_inherit=True), {"__name__": "__main__"})
    assert capsys.readouterr().out.splitlines()[-1] == "no scan yet"
