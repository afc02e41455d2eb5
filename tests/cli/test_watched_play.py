"""`irsim-gym play --policy`: what is played is what the policy perceives."""

from __future__ import annotations

from typing import Any

import pytest

from irsim_gym.cli.play.manual_play import perceived
from irsim_gym.evaluation.policies.perception import UnfitPerceptionError, perception_of
from irsim_gym.evaluation.saved_policies.policies import load_policy
from irsim_gym.scenario import load_scenario
from irsim_gym.tasks import load_task


def trained(name: str) -> Any:
    policy: Any = load_policy(name)
    return policy.perception


@pytest.mark.parametrize("task", [None, "navigation", {"name": "navigation", "agents": "robot_0", "max_steps": 7}])
def test_the_session_has_the_observations_of_the_policy_and_the_rest_of_its_task(task: Any) -> None:
    scenario, perception = load_scenario("cluttered_room"), trained("cluttered_room_memory")
    found, own = load_task(scenario, perceived(scenario, task, perception)), load_task(scenario, task)
    assert perception_of(found) == perception != perception_of(own)
    assert (found.rewards, found.endings, found.max_steps) == (own.rewards, own.endings, own.max_steps)


def test_a_robot_that_lacks_what_the_policy_observes_is_refused() -> None:
    robot = {"kinematics": {"name": "diff"}, "state": [1, 1, 0]}
    scenario = load_scenario({"world": {"name": "no_goal"}, "robot": robot})
    task = {"name": "blank", "observations": ["velocity"], "max_steps": 10}
    with pytest.raises(UnfitPerceptionError, match="does not fit 'no_goal'"):
        perceived(scenario, task, trained("cluttered_room"))
