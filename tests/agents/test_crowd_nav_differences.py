"""What agents/studies/crowd_nav_differences.py changes in crowd_nav, and nothing else."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import irsim_gym
from irsim_gym.base.arraytypes import Ints
from irsim_gym.evaluation.policies.policy import ObservationPolicy
from irsim_gym.tasks import Episodes

SCRIPT = runpy.run_path(str(Path(__file__).parents[2] / "agents" / "studies" / "crowd_nav_differences.py"))
RADIUS, JITTER = 8.485, 0.564  # of the circle, and by how much a start on it is shifted, as in the file


@pytest.mark.slow
def test_the_robot_that_sees_10_m_is_the_social_force_robot() -> None:
    """The forces of the script, in NumPy, lead where those of the behaviour do."""
    found = irsim_gym.evaluate("crowd_nav", {"own": SCRIPT["Believing"](10.0), "sfm": "sfm"}, levels=4)
    own, behavior = found.rows["own"], found.rows["sfm"]
    assert [(row.outcome, row.steps) for row in own] == [(row.outcome, row.steps) for row in behavior]
    # The behaviour forgets who is farther away, the script does not: at 10 m a push is below 2e-4 m/s2.
    assert [row.path_length for row in own] == pytest.approx([row.path_length for row in behavior], rel=1e-4)


class Watched:
    """Looks at who is elsewhere after a policy has acted: an action alone moves nobody."""

    def __init__(self) -> None:
        still = ObservationPolicy(lambda seen: np.zeros((len(next(iter(seen.values()))), 2)))
        self.policy, self.moved = SCRIPT["Restarting"](still), 0

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        self.policy.begin(episodes, worlds, levels)

    def act(self, episodes: Episodes, worlds: Ints) -> Any:
        state = episodes.simulation.state
        before = state.pose[..., :2].copy()
        actions = self.policy.act(episodes, worlds)
        moved = (state.pose[..., :2] != before).any(axis=-1)
        assert not moved[:, episodes.simulation.agents].any()
        assert np.abs(np.hypot(*state.pose[moved][:, :2].T) - RADIUS).max(initial=0.0) <= JITTER
        np.testing.assert_allclose(state.goal[moved][:, :2], -state.pose[moved][:, :2], atol=1e-9)
        self.moved += int(moved.sum())
        return actions


def test_only_who_arrives_begins_anew_on_the_circle_with_the_goal_opposite() -> None:
    watched = Watched()
    task = {"name": "navigation", "observation_form": "dict", "max_steps": 196}
    (row,) = irsim_gym.evaluate(
        "crowd_nav", {"still": watched}, levels=1, task=task, parameters={"people": 2}, references=False
    ).rows["still"]
    # Who crosses 17 m at 1 m/s and has to give way a little arrives once in 20 to 30 s.
    assert 20.0 < row.time < 30.0
    assert watched.moved == 2
