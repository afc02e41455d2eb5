"""The variants of the example trainer that docs/training_trials.md compares."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import torch

import irsim_gym

STUDIES = Path(__file__).parents[2] / "agents" / "studies"


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    monkeypatch.syspath_prepend(str(STUDIES))
    import ppo_variants

    yield ppo_variants
    for name in ("ppo_variants", "plain_ppo"):
        sys.modules.pop(name)


def test_mirrored_actions_have_the_density_of_the_agent_or_that_of_their_drawing(script: ModuleType) -> None:
    mirror = irsim_gym.make("cluttered_room").unwrapped.mirror()
    torch.manual_seed(3)
    agent = script.plain_ppo.Agent(88, 2)
    before = {"observed": torch.randn(500, 88), "action": torch.randn(500, 2), "target": torch.zeros(500)}
    before["log_prob"] = agent.log_prob(agent.actor(before["observed"]), before["action"]).detach()
    met = {name: column.clone() for name, column in before.items()}
    with torch.no_grad():
        torch.manual_seed(4)
        script.exchange_sides(agent, met, mirror, False)
        assert torch.allclose(met["log_prob"], agent.log_prob(agent.actor(met["observed"]), met["action"]), atol=1e-5)
        weighted = {name: column.clone() for name, column in before.items()}
        torch.manual_seed(4)
        script.exchange_sides(agent, weighted, mirror, True)
    assert torch.equal(weighted["action"], met["action"])
    assert torch.equal(weighted["log_prob"], before["log_prob"])
    changed = met["action"][:, 1] == -before["action"][:, 1]
    assert 150 < int(changed.sum()) < 350
    assert torch.equal(met["observed"][~changed], before["observed"][~changed])
    again = mirror.observation(met["observed"][changed].numpy())
    assert np.array_equal(again, before["observed"][changed].numpy())


def test_a_scaled_critic_keeps_its_predictions(script: ModuleType) -> None:
    torch.manual_seed(0)
    critic = script.Scaled(script.plain_ppo.network(5, 1, 1.0))
    observed = torch.randn(20, 5)
    before = critic(observed)
    critic.follow(torch.randn(100) * 7.0 + 3.0)
    assert (critic.mean, critic.deviation) != (0.0, 1.0)
    assert torch.allclose(critic(observed), before, atol=1e-5)


def test_all_variants_train_and_are_scored(script: ModuleType, tmp_path: Path) -> None:
    names, out = list(script.VARIANTS), tmp_path / "found.json"
    script.play("cluttered_room", 16_384, 1, names, 4, out)
    found = json.loads(out.read_text())["variants"]
    assert list(found) == names
    assert all(0.0 <= one["success"][0] <= 100.0 and one["cpu_seconds"][0] > 0.0 for one in found.values())
