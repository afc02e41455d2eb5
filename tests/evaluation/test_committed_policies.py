"""The policies in agents/policies still do what their results say."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.evaluation.saved_policies.policies import load_policy

AGENTS = Path(__file__).parents[2] / "agents"
LEVELS = 40


def results(scenario: str) -> Any:
    return json.loads((AGENTS / "results" / f"{scenario}.json").read_text())


def test_every_policy_has_its_results() -> None:
    for file in (AGENTS / "policies").glob("*.zip"):
        scenario, _, seed = file.stem.rpartition("_seed_")
        assert f"seed_{seed}" in {found["run"] for found in results(scenario)["seeds"]}


@pytest.mark.parametrize("scenario", ["cluttered_room", "dense_room"])
def test_a_policy_for_one_robot(scenario: str) -> None:
    rows = evaluate(
        load_policy(AGENTS / "policies" / f"{scenario}_seed_0.zip"), make_episodes(scenario, n_worlds=LEVELS), LEVELS
    )
    assert sum(row.outcome == "success" for row in rows) >= 0.9 * LEVELS


def test_a_policy_that_looks_at_pictures() -> None:
    policy = load_policy(AGENTS / "policies" / "cluttered_room_images_seed_100.zip")
    rows = evaluate(policy, make_episodes("cluttered_room", task="image_navigation", n_worlds=LEVELS), LEVELS)
    assert sum(row.outcome == "success" for row in rows) >= 0.85 * LEVELS


@pytest.mark.parametrize(("scenario", "n_robots"), [("circle_swap", 4), ("circle_swap", 8), ("random_swap", 8)])
def test_a_policy_for_a_team(scenario: str, n_robots: int) -> None:
    episodes = make_episodes(scenario, n_worlds=LEVELS, team=True, parameters={"n_robots": n_robots})
    rows = evaluate_team(load_policy(AGENTS / "policies" / f"{scenario}_seed_0.zip"), episodes, LEVELS)
    assert sum(row.is_success for row in rows) >= 0.9 * LEVELS
