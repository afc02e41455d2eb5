"""The variants of the example trainer that docs/training_trials.md compares."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import torch

import irsim_gym

AGENTS = Path(__file__).parents[2] / "agents"


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    monkeypatch.syspath_prepend(str(AGENTS))
    import ppo_variants

    yield ppo_variants
    for name in ("ppo_variants", "plain_ppo"):
        sys.modules.pop(name)


def world(side: float) -> dict[str, Any]:
    """Return a room with a robot, a goal and discs; -1 for its mirror image."""
    places = [(-2.5, 0.6, 0.4), (-1.0, -1.2, 0.5), (1.0, 0.3, 0.3)]
    sensor = {"name": "lidar2d", "range_max": 6.0, "angle_range": 6.28, "number": 180}
    robot = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}, "sensors": [sensor]}
    ways = {"state": [-4.0, 0.0, 0.4 * side], "goal": [4.0, side, 0.0], "vel_min": [0.0, -1.5], "vel_max": [1.0, 1.5]}
    return {
        "world": {"width": 10, "height": 10, "offset": [-5, -5]},
        "robot": robot | ways,
        "obstacle": [{"shape": {"name": "circle", "radius": r}, "state": [x, y * side]} for x, y, r in places],
        "task": {"name": "navigation"},
    }


def test_mirrored_observations_are_those_of_the_mirrored_world(script: ModuleType) -> None:
    env, other = (irsim_gym.make(world(side)) for side in (1.0, -1.0))
    (observed, _), (expected, _) = env.reset(seed=0), other.reset(seed=0)
    rng, met = np.random.default_rng(1), 0
    for _ in range(40):
        assert script.mirrored(torch.as_tensor(observed)[None])[0].numpy() == pytest.approx(expected, abs=1e-5)
        met += 1
        action = np.array([rng.uniform(-0.5, 1.0), rng.uniform(-1.0, 1.0)], np.float32)
        observed, _, ended, _, _ = env.step(action)
        expected, _, other_ended, _, _ = other.step(action * np.array([1.0, -1.0], np.float32))
        assert ended == other_ended
        if ended:
            break
    assert met > 10, "the robot has seen too little"
    assert np.ptp(observed[76:]) > 0.0, "no trail"


def test_mirrored_actions_have_the_density_of_the_agent_or_that_of_their_drawing(script: ModuleType) -> None:
    torch.manual_seed(3)
    agent = script.plain_ppo.Agent(88, 2)
    before = {"observed": torch.randn(500, 88), "action": torch.randn(500, 2), "target": torch.zeros(500)}
    before["log_prob"] = agent.log_prob(agent.actor(before["observed"]), before["action"]).detach()
    met = {name: column.clone() for name, column in before.items()}
    with torch.no_grad():
        torch.manual_seed(4)
        script.exchange_sides(agent, met, False)
        assert torch.allclose(met["log_prob"], agent.log_prob(agent.actor(met["observed"]), met["action"]), atol=1e-5)
        weighted = {name: column.clone() for name, column in before.items()}
        torch.manual_seed(4)
        script.exchange_sides(agent, weighted, True)
    assert torch.equal(weighted["action"], met["action"])
    assert torch.equal(weighted["log_prob"], before["log_prob"])
    changed = met["action"][:, 1] == -before["action"][:, 1]
    assert 150 < int(changed.sum()) < 350
    assert torch.equal(met["observed"][~changed], before["observed"][~changed])
    assert torch.equal(script.mirrored(met["observed"][changed]), before["observed"][changed])


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
