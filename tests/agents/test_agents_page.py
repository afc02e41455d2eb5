"""What agents/README.md shows: blocks in Python and short commands are run, of the others the options are looked up."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from command_line import run

from irsim_gym.training.search_space import read_space
from irsim_gym.training.training_request import TrainingRequest
from irsim_gym.training.trial_settings import check_space

PAGE = Path(__file__).parents[2] / "agents" / "README.md"
GROUPS = {"policies", "suite", "levels"}
"""Commands that have commands of their own."""
SHORT = {"list", "show", "rollout"}


def blocks(*languages: str) -> list[str]:
    found = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    return [text for language, text in found if language in languages]


def commands() -> list[list[str]]:
    lines = [line.strip() for block in blocks("", "bash") for line in block.splitlines()]
    return [shlex.split(line, comments=True)[1:] for line in lines if line.startswith("irsim-gym ")]


@pytest.mark.parametrize("block", blocks("python"))
def test_blocks_in_python_run(block: str) -> None:
    exec(compile(block, "agents/README.md", "exec"), {})


@pytest.mark.parametrize("block", blocks("yaml"))
def test_search_spaces_can_be_read(block: str, tmp_path: Path) -> None:
    (tmp_path / "space.yaml").write_text(block, encoding="utf-8")
    check_space(TrainingRequest("cluttered_room"), read_space(tmp_path / "space.yaml"))


@pytest.mark.parametrize("words", commands(), ids=" ".join)
def test_commands_exist(words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    place = 3 if words[:2] == ["levels", "import"] else 2 if words[0] in GROUPS else 1
    if words[place - 1] in SHORT:
        assert run(monkeypatch, *words) == 0
        return
    monkeypatch.setenv("COLUMNS", "200")
    assert run(monkeypatch, *words[:place], "--help") == 0
    shown = capsys.readouterr().out
    assert [word for word in words if word.startswith("--") and word not in shown] == []
