"""Tasks of configs/tasks in the scenarios that they are made for."""

from __future__ import annotations

import numpy as np
import pytest

import irsim_gym
from irsim_gym.base.families import OBSERVATIONS, REWARDS
from irsim_gym.evaluation.policies.perception import perception_differences, perception_of
from irsim_gym.scenario import load_scenario
from irsim_gym.tasks import Task, load_task
from irsim_gym.tasks.observations.own.pending import Pending
from irsim_gym.tasks.observations.seen_map.way_on_seen_map import WayOnSeenMap

SINGLE = {"cluttered_room": {}, "rooms": {}, "maze": {}, "cellular_cave": {}, "jaxnav_single": {},
          "crowd_nav": {"goal_change": 0.5}}  # fmt: skip
"""Scenarios of tier core with one robot, and their parameters."""


def task(scenario: str, name: str | None) -> Task:
    return load_task(load_scenario(scenario), name)


def test_patient_navigation_is_seen_navigation_with_more_time_to_stand() -> None:
    patient, seen = task("narrow_door", "patient_navigation"), task("narrow_door", "seen_navigation")
    assert (patient.deadlock_time, seen.deadlock_time) == (5.0, 3.0)
    assert (patient.observations, patient.rewards, patient.endings) == (seen.observations, seen.rewards, seen.endings)
    assert patient.max_steps == seen.max_steps == task("narrow_door", None).max_steps


def weights(task: Task) -> dict[str, float]:
    return {REWARDS.name_of(type(term)): term.weight for term in task.rewards}


def test_a_team_of_many_learns_by_two_tasks_and_sees_the_same_in_both() -> None:
    crowded, careful = (task("rl_rvo_random", f"{name}_team_navigation") for name in ("crowded", "careful"))
    assert crowded.observations == careful.observations
    assert weights(careful) == {**weights(crowded), "collision": 40.0, "time": 1.0}
    assert crowded.max_steps == careful.max_steps == task("rl_rvo_random", None).max_steps


def test_pose_navigation_tells_where_the_goal_faces() -> None:
    names = [OBSERVATIONS.name_of(type(term)) for term in task("parking", "pose_navigation").observations]
    assert {"goal", "goal_heading", "velocity", "position", "heading", "scan"} <= set(names)
    assert task("parking", "pose_navigation").max_steps == task("parking", None).max_steps


def test_general_navigation_is_one_perception_in_all_of_core() -> None:
    found = {
        name: perception_of(load_task(load_scenario(name, own), "general_navigation")) for name, own in SINGLE.items()
    }
    assert perception_differences(found) == []
    with_map, crowd = task("maze", "general_navigation"), task("crowd_nav", "general_navigation")
    assert (with_map.max_steps, crowd.max_steps) == (task("maze", None).max_steps, task("crowd_nav", None).max_steps)


@pytest.mark.parametrize("name", ["jaxnav_single", "crowd_nav"])
def test_general_navigation_is_the_same_in_a_batch_as_alone(name: str) -> None:
    own = {"task": "general_navigation", "render_mode": None, **SINGLE[name]}
    batch, alone = irsim_gym.make_vec(name, num_envs=3, **own), irsim_gym.make(name, **own)
    seen, _ = batch.reset(seed=5)
    first, _ = alone.reset(seed=7)
    random = np.random.default_rng(1)
    for _ in range(12):
        np.testing.assert_array_equal(seen[2], first)
        assert alone.observation_space.contains(first)
        actions = random.uniform(-1.0, 1.0, (3, 2)).astype(np.float32)
        seen, *_ = batch.step(actions)
        first, _, terminated, *_ = alone.step(actions[2])
        if terminated:
            break
    batch.close()
    alone.close()


def test_the_way_of_wide_way_navigation_keeps_its_distance() -> None:
    wide, seen = task("dense_room", "wide_way_navigation"), task("dense_room", "seen_navigation")
    (own,) = (one for one in wide.observations if one not in seen.observations)
    assert isinstance(own, WayOnSeenMap)
    assert (own.cell, own.clearance) == (0.08, 0.04)
    assert [type(one) for one in wide.observations] == [type(one) for one in seen.observations]
    assert (wide.rewards, wide.endings, wide.deadlock_time) == (seen.rewards, seen.endings, seen.deadlock_time)


@pytest.mark.parametrize(
    ("scenario", "name", "robot"),
    [
        ("dense_room", "wide_way_navigation", "robot_wide_way_navigation"),
        ("maze", "seen_navigation", "robot_seen_navigation"),
    ],
)
def test_tasks_of_late_robots_predict_and_add_the_commands_under_way(scenario: str, name: str, robot: str) -> None:
    original, late = task(scenario, name), task(scenario, robot)
    assert (original.predict, late.predict) == (False, True)
    *same, added = late.observations
    assert tuple(same) == original.observations
    assert isinstance(added, Pending)
    assert (added.steps, late.endings, late.max_steps) == (7, original.endings, original.max_steps)
    assert weights(late).keys() == weights(original).keys()
    assert weights(late)["time"] >= weights(original)["time"]
