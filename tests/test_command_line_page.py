"""What docs/command_line.md shows is run."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

import pytest
from command_line import run
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from test_readme import ROOT, blocks, commands

PAGE = ROOT / "docs" / "command_line.md"
ASKS_FOR_A_SHELL = ("--install-completion", "--show-completion")


@pytest.mark.parametrize("command", commands(PAGE))
def test_commands_run(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = shlex.split(command, comments=True)[1:]
    monkeypatch.chdir(tmp_path)
    if words[0] == "train":  # other tests run it with a stand-in of the service
        words = [words[0], "--help"]
    if words[0] in ASKS_FOR_A_SHELL:
        words = ["--help"]
    assert run(monkeypatch, *words) == 0


def test_the_help_names_the_completion(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    run(monkeypatch, "--help")
    shown = capsys.readouterr().out
    assert all(option in shown for option in ASKS_FOR_A_SHELL)


@pytest.mark.slow
def test_the_callback_of_the_page_logs_for_tensorboard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (block,) = blocks(PAGE, "python")
    exec(compile(block.text, str(block), "exec", dont_inherit=True), {"__name__": "__main__"})
    (folder,) = Path("logs").iterdir()
    read = EventAccumulator(os.fspath(folder))
    read.Reload()
    assert {"outcome/success", "reward/progress", "rollout/success_rate"} <= set(read.Tags()["scalars"])
