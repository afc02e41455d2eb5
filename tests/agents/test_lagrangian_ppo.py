"""The example of training under a limit of costs."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

FOLDER = Path(__file__).parents[2] / "agents" / "studies"


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(str(FOLDER))
    threads = torch.get_num_threads()
    yield runpy.run_path(str(FOLDER / "lagrangian_ppo.py"))
    torch.set_num_threads(threads)
    sys.modules.pop("plain_ppo", None)


def test_the_multiplier_grows_above_the_limit_and_is_0_without_one(script, capsys):
    steps = 3 * script["N_STEPS"] * script["N_WORLDS"]
    _, tight = script["train"]("sparse_circles", 0.5, 0.0, steps)
    _, free = script["train"]("sparse_circles", 0.5, np.inf, steps)
    said = capsys.readouterr().out.splitlines()
    assert tight > 0.0 == free
    assert len(said) == 2
    assert "costs per episode, x 0.00" in said[1]


def test_costs_of_an_episode_are_summed_up_to_its_end(script):
    class Given:
        cost = torch.ones(script["N_WORLDS"])
        terminated, truncated = torch.zeros(2, script["N_WORLDS"], dtype=torch.bool)

        def step(self, actions):
            self.truncated = torch.arange(script["N_WORLDS"]) == 3

    rows = script["Rows"](Given())
    rows.step(None)
    rows.step(None)
    assert list(rows.episodes_cost) == [1.0, 1.0]
    assert rows.spent[2:5].tolist() == [2.0, 0.0, 2.0]
    assert len(rows.costs) == 2


def test_the_file_has_at_most_80_lines_of_code():
    lines = (FOLDER / "lagrangian_ppo.py").read_text(encoding="utf-8").splitlines()
    assert sum(1 for line in lines if line.strip() and not line.strip().startswith("#")) <= 80
