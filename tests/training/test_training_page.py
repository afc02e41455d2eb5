"""What docs/more_training.md shows: Python blocks run, the task is read, and options of commands are looked up."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from command_line import run

from irsim_gym.scenario import load_scenario
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.settings.mixture import read_mixture, read_part

PAGE = Path(__file__).parents[2] / "docs" / "more_training.md"


def blocks(language: str) -> list[str]:
    found = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    return [text for name, text in found if name == language]


COMMANDS = [shlex.split(line)[1:] for block in blocks("") for line in block.splitlines() if line]


@pytest.mark.filterwarnings("ignore:You have specified a mini-batch size")
@pytest.mark.parametrize("block", blocks("python"))
def test_blocks_in_python_run(block: str) -> None:
    exec(compile(block, "docs/more_training.md", "exec"), {})


@pytest.mark.parametrize("block", blocks("yaml"))
def test_the_mixture_can_be_trained(block: str, tmp_path: Path) -> None:
    file = tmp_path / "walls_and_people.yaml"
    file.write_text(block)
    settings = TrainingRequest(str(file)).with_mixture(read_mixture(file)).settings()
    assert [one.share for one in settings.mixture] == [1.0, 2.0]


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_commands_exist(words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    assert run(monkeypatch, words[0], "--help") == 0
    shown = capsys.readouterr().out
    assert [word for word in words if word.startswith("--") and word not in shown] == []
    if "--mixture" in words:
        names = words[2 : next((k for k, word in enumerate(words) if k > 1 and word.startswith("--")), len(words))]
        for part in map(read_part, names):
            load_scenario(part.scenario, part.parameters)
