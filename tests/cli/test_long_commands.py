"""What pages show in blocks without a language: long commands, whose options are looked up; and spaces to search."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from command_line import run

from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.searches.search_space import read_space
from irsim_gym.training.searches.trial_settings import check_space

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "agents" / "README.md", *sorted((ROOT / "docs").glob("*.md")))
GROUPS = {"policies", "suite", "levels"}
"""Commands that have commands of their own."""


def blocks(page: Path, language: str) -> list[str]:
    found = re.findall(r"^```(\w*)\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    return [text for name, text in found if name == language]


def commands() -> dict[str, list[str]]:
    lines = [line.strip() for page in PAGES for block in blocks(page, "") for line in block.splitlines()]
    return {line: shlex.split(line, comments=True)[1:] for line in lines if line.startswith("irsim-gym ")}


def test_search_spaces_can_be_read(tmp_path: Path) -> None:
    (space,) = blocks(ROOT / "docs" / "hyperparameters.md", "yaml")
    (tmp_path / "space.yaml").write_text(space, encoding="utf-8")
    check_space(TrainingRequest("cluttered_room"), read_space(tmp_path / "space.yaml"))


@pytest.mark.parametrize("words", commands().values(), ids=list(commands()))
def test_commands_exist(words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    place = 3 if words[:2] == ["levels", "import"] else 2 if words[0] in GROUPS else 1
    monkeypatch.setenv("COLUMNS", "200")
    assert run(monkeypatch, *words[:place], "--help") == 0
    shown = capsys.readouterr().out
    assert [word for word in words if word.startswith("--") and word not in shown] == []
