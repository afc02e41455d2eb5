"""agents/studies/less_noise.py: a policy whose actions have less noise."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from stable_baselines3 import PPO

STUDIES = Path(__file__).parents[2] / "agents" / "studies"


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(STUDIES))
    import less_noise

    return less_noise


def test_only_the_deviation_of_the_actions_changes(script: Any, tmp_path: Path) -> None:
    before = PPO("MlpPolicy", gymnasium.make("Pendulum-v1"), n_steps=8, batch_size=8, device="cpu")
    before.save(tmp_path / "before.zip")
    script.with_deviation(tmp_path / "before.zip", 0.2, tmp_path / "after.zip")
    weights = [model.policy.state_dict() for model in (before, PPO.load(tmp_path / "after.zip", device="cpu"))]
    assert weights[1]["log_std"].tolist() == pytest.approx([math.log(0.2)])
    assert weights[0]["log_std"].tolist() != weights[1]["log_std"].tolist()
    assert weights[0].keys() == weights[1].keys()
    assert all(torch.equal(weights[0][name], weights[1][name]) for name in weights[0] if name != "log_std")
    seen = np.zeros((1, 3), np.float32)
    actions = [model.predict(seen, deterministic=True)[0] for model in (before, PPO.load(tmp_path / "after.zip"))]
    np.testing.assert_array_equal(*actions)
