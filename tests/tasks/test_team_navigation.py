"""The task that teams learn: a robot knows others by its own scans alone."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import Episodes, Outcome, load_task


def begin(name: str, n_worlds: int, **parameters: int) -> Episodes:
    """Return episodes in which all worlds play level 3."""
    spec = load_scenario(name, parameters=parameters)
    task = load_task(spec, team=True)
    assert task.name == "team_navigation"
    episodes = Episodes(compile(spec, n_worlds, agents=task.agents), task)
    episodes.begin(np.arange(n_worlds), np.full(n_worlds, 3))
    return episodes


def test_another_robot_is_unknown_until_the_lidar_meets_it() -> None:
    episodes = begin("circle_swap", 2, n_robots=2)
    pose = episodes.simulation.state.pose
    actions = np.full((2, 2, 2), [-1.0, 0.0])
    actions[1, 1] = [1.0, 0.0]  # in the second world the other robot comes nearer
    was_seen = False
    for _ in range(40):
        episodes.step(actions)
        gap = np.linalg.norm(pose[1, 1, :2] - pose[1, 0, :2]) - 0.2
        same = np.array_equal(episodes.view.observation[0, 0], episodes.view.observation[1, 0])
        if gap > 6.0:
            assert same
        elif gap < 5.9:
            was_seen = True
            assert not same
    assert was_seen


@pytest.mark.parametrize("name", ["circle_swap", "random_swap"])
def test_standing_still_costs_less_than_a_collision(name: str) -> None:
    episodes = begin(name, 1)
    total = np.zeros(episodes.n_agents)
    while episodes.view.live.any():
        episodes.step(np.full((1, episodes.n_agents, 2), [-1.0, 0.0]))
        total += episodes.view.reward[0]
    assert (episodes.view.infos["outcome"] == Outcome.TIMEOUT).all()
    collision = next(term.weight for term in episodes.task.rewards if type(term).__name__ == "Collision")
    assert (total < 0.0).all()
    assert (total > -collision).all()
