"""The example of a trainer of one's own on ``make_batch``."""

import runpy
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import torch

SCRIPT = Path(__file__).parents[2] / "agents" / "centralised_critic.py"


@pytest.fixture
def script() -> dict[str, Any]:
    return runpy.run_path(str(SCRIPT))


@pytest.fixture(autouse=True)
def one_torch_thread() -> Iterator[None]:
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


def test_the_example_runs(script: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    first = script["train"]("random_swap", n_worlds=8, n_steps=8, updates=10, n_robots=2)
    assert capsys.readouterr().out.startswith("    1,280 steps: ")
    assert script["train"]("random_swap", n_worlds=8, n_steps=8, updates=10, n_robots=2) == first


def test_parameters_and_mistakes_on_the_command_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = [str(SCRIPT), "--updates", "0", "--set", "n_robots=many", "--set", "speed=1"]
    monkeypatch.setattr(sys, "argv", arguments)
    with pytest.raises(SystemExit) as end:
        runpy.run_path(str(SCRIPT), run_name="__main__")
    assert end.value.code == 1
    said = capsys.readouterr().err
    assert "speed" in said
    assert "Traceback" not in said


@pytest.mark.slow
def test_two_robots_learn_to_pass_each_other(script: dict[str, Any]) -> None:
    assert script["train"]("random_swap", n_worlds=32, updates=60, n_robots=2) > 0.9
