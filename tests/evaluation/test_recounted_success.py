"""What policies on the shelf are said to solve they solve: arrivals and contacts counted anew from poses."""

from __future__ import annotations

from typing import Any

import pytest
from recount import Recount

from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.policies.reference_policies import reference_policy
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.evaluation.saved_policies.policies import load_policy
from irsim_gym.evaluation.saved_policies.shelf import card_of, shelf_files

LEVELS = {"cluttered_room": 30}
"""Levels in every run of the tests; a hundred, of all policies, with the slow ones."""


def counted(policy: Any, worlds: Perceived, levels: int) -> tuple[list[list[bool]], list[list[bool]]]:
    """Return which agents arrive in each level: as evaluations say, and as counted anew."""
    episodes, count = worlds.of(policy), Recount()
    if episodes.n_agents > 1:
        teams = evaluate_team(policy, episodes, levels, watcher=count)
        said = [[agent.episode.outcome == "success" for agent in team.agents] for team in teams]
    else:
        said = [[row.outcome == "success"] for row in evaluate(policy, episodes, levels, watcher=count)]
    return said, [count.arrived[index].tolist() for index in range(levels)]


@pytest.mark.parametrize(
    ("name", "levels"), [*LEVELS.items(), *(pytest.param(name, 100, marks=pytest.mark.slow) for name in shelf_files())]
)
def test_success_counted_anew(name: str, levels: int) -> None:
    found = card_of(name)
    assert found is not None
    where = found.scenario
    chosen: dict[str, Any] = {"task": where.task, "parameters": where.parameters, "team": where.team is not None}
    worlds = Perceived(make_episodes(where.name, n_worlds=25, **chosen))
    said, anew = counted(load_policy(name), worlds, levels)
    assert anew == said
    assert any(map(any, said))


def test_failures_counted_anew() -> None:
    """Robots that drive straight at their goals touch something in two thirds of the levels."""
    said, anew = counted(reference_policy("dash"), Perceived(make_episodes("cluttered_room", n_worlds=30)), 30)
    assert anew == said
    assert 3 < sum(map(any, said)) < 20
