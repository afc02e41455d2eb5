"""The example of a trainer of one's own on ``torch_rows``."""

from __future__ import annotations

import runpy
import sys
from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

import irsim_gym

SCRIPT = Path(__file__).parents[2] / "agents" / "plain_ppo.py"


@pytest.fixture
def script() -> dict[str, Any]:
    return runpy.run_path(str(SCRIPT))


@pytest.fixture(autouse=True)
def one_torch_thread():
    threads = torch.get_num_threads()
    yield
    torch.set_num_threads(threads)


def test_advantages_are_those_of_their_definition(script):
    """Against the sum over the rest of the episode, written out."""
    rng = np.random.default_rng(0)
    value, after, reward = (torch.tensor(rng.normal(size=(7, 3)), dtype=torch.float32) for _ in range(3))
    ended = torch.zeros(7, 3, dtype=torch.bool)
    ended[3, 1] = ended[6, 2] = True
    found = script["advantages"](value, after, reward, ended)
    error, decay = reward + script["GAMMA"] * after - value, script["GAMMA"] * script["LAMBDA"]
    for world in range(3):
        for t in range(7):
            last = next((k for k in range(t, 7) if ended[k, world]), 6)
            wanted = sum(decay ** (k - t) * error[k, world].item() for k in range(t, last + 1))
            assert found[t, world].item() == pytest.approx(wanted, abs=1e-5)


def test_what_is_met_is_bootstrapped_at_time_limits_alone(script):
    """Against the steps of a ``make_vec`` with the same actions."""
    kwargs = {"num_envs": 4, "max_steps": 12, "autoreset_mode": "SameStep"}
    rows, env = (irsim_gym.make_vec("sparse_circles", **kwargs) for _ in range(2))
    rows = irsim_gym.torch_rows(rows)
    rows.reset(seed=0)
    observed, _ = env.reset(seed=0)
    torch.manual_seed(0)
    agent = script["Agent"](observed.shape[1], 2)
    with torch.no_grad():
        met = script["collect"](agent, rows, 40, deque())
        actions, kinds = met["action"].reshape(40, 4, 2), set()
        target, advantage = met["target"].reshape(40, 4), met["advantage"].reshape(40, 4)
        for t in range(40):
            np.testing.assert_array_equal(met["observed"].reshape(40, 4, -1)[t], observed)
            observed, reward, terminated, truncated, infos = env.step(actions[t].numpy())
            for w in np.flatnonzero(terminated | truncated):
                cut = bool(truncated[w] and not terminated[w])
                kinds.add(cut)
                left = agent.critic(torch.as_tensor(infos["final_obs"][w])).item() if cut else 0.0
                assert target[t, w].item() == pytest.approx(reward[w] + script["GAMMA"] * left, abs=1e-5)
        assert kinds == {True, False}
        assert torch.isfinite(advantage).all()


def test_the_command_trains_evaluates_and_writes_the_weights(script, tmp_path, monkeypatch, capsys):
    file = tmp_path / "policy.pt"
    options = ["--steps", "20000", "--seed", "3", "--levels", "5", "--out", str(file)]
    monkeypatch.setattr(sys, "argv", [str(SCRIPT), "sparse_circles", *options])
    found = runpy.run_path(str(SCRIPT), run_name="__main__")
    said = capsys.readouterr().out
    assert said.startswith("   32,768 steps: ")
    assert "plain_ppo" in said
    agent = script["Agent"](found["trained"].actor[0].in_features, 2)
    before = agent(np.ones((1, agent.actor[0].in_features), np.float32))
    agent.load_state_dict(torch.load(file))
    after = agent(np.ones((1, agent.actor[0].in_features), np.float32))
    assert (before != after).any()
    np.testing.assert_array_equal(after, found["trained"](np.ones((1, agent.actor[0].in_features), np.float32)))


@pytest.mark.slow
def test_it_learns_cluttered_room(script):
    found = irsim_gym.evaluate("cluttered_room", script["train"]("cluttered_room", seed=1), references=False)
    assert found.summaries[0].success.value > 0.95
