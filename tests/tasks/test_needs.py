"""What observations need on a robot: each kind says it, and descriptions and cards show it."""

from __future__ import annotations

import pytest
from task_tools import BALL, ROBOT

import irsim_gym
from irsim_gym.base import families
from irsim_gym.envs.described.description_text import headlines
from irsim_gym.evaluation.policies.perception import perceived_task, perception_from
from irsim_gym.evaluation.saved_policies.shelf import read_policy, shelf_files
from irsim_gym.plugins import OBSERVATIONS
from irsim_gym.scenario import load_scenario
from irsim_gym.tasks import load_task
from irsim_gym.tasks.terms.term import NEEDS, needs_of

WORLD = {"robot": ROBOT, "obstacle": BALL}


def test_each_kind_says_what_it_needs() -> None:
    families.load()
    said = {entry.name: entry.kind().needs for entry in OBSERVATIONS if entry.kind.__module__.startswith("irsim_gym.")}
    assert all(set(needs) <= set(NEEDS) for needs in said.values())
    assert said["scan"] == ("scan",)
    assert said["trail"] == ("odometry",)
    assert said["own_body"] == ()
    assert said["way_on_seen_map"] == ("scan", "odometry", "grid")
    assert said["yielding_way"] == ("scan", "odometry", "grid", "messages")


def test_an_image_needs_what_it_shows() -> None:
    image = OBSERVATIONS.entry("occupancy_image").kind
    assert image().needs == ("odometry", "bodies")
    assert image(from_scan=True).needs == ("scan", "odometry")
    for channel in ("robot_channel", "movable_channel"):
        assert image(from_scan=True, **{channel: True}).needs == ("scan", "odometry", "bodies")


def test_a_description_shows_the_needs_and_who_does_not_say(monkeypatch: pytest.MonkeyPatch) -> None:
    families.load()
    monkeypatch.setattr(OBSERVATIONS, "_entries", dict(OBSERVATIONS._entries))

    @irsim_gym.observation("silent")
    def silent(ego):
        return 0.0

    env = irsim_gym.make(WORLD, task={"observations": [{"name": "scan"}, {"name": "silent"}]})
    described = env.unwrapped.describe()
    assert described.block("scan").needs == ("scan",)
    assert described.block("silent").needs is None
    assert described.needs == ("scan", "odometry")
    assert headlines(described)[-1] == "needed on a robot: scan, odometry; not said by silent (declare 'needs')"


def test_a_function_that_says_something_unknown_is_refused() -> None:
    with pytest.raises(irsim_gym.errors.KindError, match=r"'needs' must be what a robot must have for it, .*'lidar'"):

        @irsim_gym.observation("lost", needs=["lidar"])
        def lost(ego):
            return 0.0


@pytest.mark.parametrize("name", shelf_files())
def test_a_card_says_what_its_policy_needs(name: str) -> None:
    policy = read_policy(shelf_files()[name])
    assert policy.card is not None
    assert policy.perception is not None
    scenario = load_scenario(policy.card.scenario.name)
    task = perceived_task(scenario, load_task(scenario, policy.card.scenario.task), perception_from(policy.perception))
    assert policy.card.needs == needs_of(task.observations)
