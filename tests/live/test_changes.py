"""Bodies that come and go, and obstacles that are scattered."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_world import DIFF, SCENARIO, world

import irsim_gym
from irsim_gym.base import families
from irsim_gym.errors import PlacementError, ScenarioError, UnknownNameError

RANDOM = {
    "shape": {"name": "circle", "random_shape": True, "radius_range": [0.2, 0.6]},
    "distribution": {"name": "random"},
}


def test_an_added_body_takes_part_and_the_rest_goes_on() -> None:
    here, alone = world(), world()
    for each in (here, alone):
        for _ in range(3):
            each.step([0.4, 0.1], 1)
    added = here.add(shape={"name": "circle", "radius": 0.3}, state=[9, 1, 0])
    assert (added.name, added.id, added.role, added.state.tolist()) == ("obstacle_4", 4, "obstacle", [9, 1, 0])
    assert here.names[-1] == "obstacle_4"
    assert here.time == alone.time
    for each in (here, alone):
        each.step()
    for name in alone.names:
        assert np.array_equal(here[name].state, alone[name].state)
        assert np.array_equal(here[name].velocity, alone[name].velocity)
    here.robot.set_state([8.6, 1, 0])
    here.step()
    assert here.robot.hit == added
    here.reset()
    assert added.state.tolist() == [9, 1, 0]
    assert here.robot.state.tolist() == [1, 1, 0]
    here.reset(random=True)
    assert "obstacle_4" not in here.names


def test_a_robot_can_be_added_and_driven() -> None:
    here = world()
    robot = here.create_robot(name="late", **DIFF, state=[3, 1, 0], goal=[9, 1], behavior={"name": "dash"})
    assert here.robots[-1] == robot
    here.step()
    assert robot.velocity[0] == pytest.approx(1.0)
    here.step([0.2, 0.1], "late")
    assert robot.velocity.tolist() == [0.2, 0.1]
    assert robot.trajectory[:, 0].tolist() == pytest.approx([3.0, 3.1, 3.12])


def test_removed_bodies_are_gone_and_numbers_stay() -> None:
    here = world()
    here.step()
    wall, mover = here["obstacle_2"], here["obstacle_3"]
    here.remove("obstacle_2")
    assert here.names == ["robot_0", "robot_1", "obstacle_3"]
    assert mover.id == 3
    with pytest.raises(UnknownNameError, match="no body named 'obstacle_2'"):
        _ = wall.state
    here.step([0.3, 0.0], 3)
    assert mover.velocity.tolist() == [0.3, 0.0]
    assert here.create_obstacle(**DIFF).id == 4
    here.delete_object(4)
    here.delete_object(0)
    assert here.robot.name == "robot_1"
    assert here.create_obstacle(**DIFF).name == "obstacle_5"
    with pytest.raises(UnknownNameError, match="no body number 0"):
        here.remove(0)


def test_what_holds_a_body_can_be_removed() -> None:
    here = world(robot={**DIFF, "state": [4.6, 4.55, 0]})  # in the wall's lower side, after a step
    here.robot.set_state([5, 4.6, 0])
    here.step([0.5, 0.0])
    assert here.robot.stopped
    here.remove("obstacle_1")
    assert here.robot.hit is None
    here.step([0.5, 0.0])  # flags are those of the step before, as in IR-SIM
    here.step([0.5, 0.0])
    assert here.robot.velocity[0] == 0.5


def test_random_bodies_are_added_clear_of_the_others_and_keep_their_outlines() -> None:
    here = world(obstacle={**RANDOM, "number": 3}, robot=SCENARIO["robot"])
    radii = [body.radius for body in here.obstacles]
    places = [body.state for body in here.obstacles]
    added = here.add(**RANDOM)
    assert [body.radius for body in here.obstacles[:3]] == radii
    assert all(np.array_equal(body.state, place) for body, place in zip(here.obstacles, places, strict=False))
    assert 0.2 <= added.radius <= 0.6
    here.refresh()
    assert not any(body.collided for body in here)
    here.remove(here.obstacles[0].name)
    assert [body.radius for body in here.obstacles] == [*radii[1:], added.radius]


def test_a_bad_entry_changes_nothing() -> None:
    here = world()
    with pytest.raises(ScenarioError, match=r"obstacle\.shape\.radius: must be > 0, got -1"):
        here.add(shape={"name": "circle", "radius": -1})
    with pytest.raises(ScenarioError, match=r"obstacle\.name: the name 'robot_0' is given to several bodies"):
        here.add(name="robot_0")
    with pytest.raises(ValueError, match="one body at a time"):
        here.add(number=2)
    with pytest.raises(ValueError, match="role must be"):
        here.add("person")  # type: ignore[arg-type]
    with pytest.raises(PlacementError, match="no place found for 'obstacle_4'"):
        here.add(shape={"name": "circle", "radius": 8.0}, distribution={"name": "random"})
    assert len(here) == 4
    here.step()


def test_goals_that_were_set_survive_a_change() -> None:
    here = world()
    here.robot.set_goal([[2, 2], [3, 3], [4, 4]])
    here.add()
    assert here.robot.goals[:, 0].tolist() == [2, 3, 4]
    here.reset()
    assert here.robot.goals[:, 0].tolist() == [9]


def test_obstacles_are_scattered() -> None:
    here = world()
    before = here["obstacle_2"].state
    here.random_obstacle_position([2, 2, -1], [8, 8, 1], non_overlapping=True)
    moved = [body.state for body in here.obstacles]
    assert not np.array_equal(moved[0], before)
    assert all((state >= [2, 2, -1]).all() and (state <= [8, 8, 1]).all() for state in moved)
    assert not any(body.collided for body in here)
    here.step()
    here.reset()
    assert all(np.array_equal(body.state, state) for body, state in zip(here.obstacles, moved, strict=True))
    here.random_obstacle_position([1, 1, 0], [1, 1, 0.1], ids=["obstacle_2"])
    assert here.robot.hit == here["obstacle_2"]


def test_obstacles_that_find_no_place_stay() -> None:
    here = world()
    before = [body.state for body in here.obstacles]
    with pytest.raises(PlacementError, match="clear of the others"):
        here.random_obstacle_position([1, 1, 0], [1.1, 1.1, 0.1], non_overlapping=True)
    assert all(np.array_equal(body.state, state) for body, state in zip(here.obstacles, before, strict=True))
    here.refresh()
    assert not any(body.collided for body in here)


def test_behaviours_in_python_rest_under_an_action_and_remember_through_a_change(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    families.load()
    monkeypatch.setattr(families.BEHAVIORS, "_entries", dict(families.BEHAVIORS._entries))

    @irsim_gym.behavior("counter")
    def count(ego: Any, others: Any) -> list[float]:
        ego.memory["calls"] = ego.memory.get("calls", 0) + 1
        return [0.1 * ego.memory["calls"], 0.0]

    robot = {**DIFF, "behavior": {"name": "counter"}, "goal": [9, 9]}
    here = world(robot=[{**robot, "state": [1, 1, 0]}, {**robot, "state": [1, 5, 0]}])
    here.step()
    here.step([0.9, 0.0])
    here.add(state=[9, 1, 0])
    here.remove("robot_1")
    here.step()
    assert here.robot.velocity[0] == pytest.approx(0.2)  # its second call
    here.reset()
    here.step()
    assert here.robot.velocity[0] == pytest.approx(0.1)


def test_the_map_stays_the_last_body_until_it_is_removed() -> None:
    cells = np.zeros((10, 10))
    cells[5, 0] = 100  # the cell from (5, 0) to (6, 1)
    here = world(world={"obstacle_map": {"name": "array", "cells": cells.tolist()}}, obstacle=None)
    assert here.names == ["robot_0", "robot_1", "obstacle_2"]
    assert (here[2].info.shape, here[2].vertices.shape, here[2].radius) == ("map", (0, 2), 0.0)
    added = here.add(state=[8, 8, 0])
    assert here.names == ["robot_0", "robot_1", "obstacle_3", "obstacle_2"]
    assert (added.id, added.state.tolist()) == (3, [8, 8, 0])
    here.robot.set_state([5.5, 0.5, 0])
    here.step([0.0, 0.0])
    assert here.robot.hit == here["obstacle_2"]
    here.random_obstacle_position([7, 7, 0], [8, 8, 1])
    robot_1 = here.robots[1].state.tolist()
    with pytest.raises(ValueError, match="its cells stay"):
        here.random_obstacle_position(ids=["obstacle_3", "obstacle_2"])
    with pytest.raises(ValueError, match="'robot_1' is no obstacle: set_state moves a robot"):
        here.random_obstacle_position(ids=["obstacle_3", 1])
    with pytest.raises(UnknownNameError, match="no body number 9"):
        here.random_obstacle_position(ids=["obstacle_3", 9])
    assert here.robots[1].state.tolist() == robot_1
    with pytest.raises(ValueError, match="its cells stay"):
        here["obstacle_2"].set_state([1, 1, 0])
    here.remove("obstacle_2")
    here.step([0.0, 0.0])
    assert not here.robot.collided


NEIGHBOR: dict[str, Any] = {**DIFF, "kinematics": {"name": "omni"}, "behavior": {"name": "rvo"}, "goal": [9, 2]}
COMPOUND: dict[str, Any] = {
    "name": "compound",
    "parts": [
        {"name": "circle", "radius": 0.6, "pose": [0.5, 0.3, 0]},
        {"name": "rectangle", "length": 1.2, "width": 0.4},
    ],
}


def test_the_first_body_that_looks_at_others_sees_their_sizes() -> None:
    obstacle = {"shape": COMPOUND, "state": [5, 5, 0]}
    here = world(obstacle=obstacle)
    there = world(obstacle=obstacle, robot=[*SCENARIO["robot"], {**NEIGHBOR, "state": [1, 2, 0]}])
    here.create_robot(**NEIGHBOR, state=[1, 2, 0])
    here.add(**RANDOM)
    model, whole = here.simulation.model, there.simulation.model
    for name, other in (("robot_0", "robot_0"), ("obstacle_2", "obstacle_3")):
        b, c = here.simulation.body(name), there.simulation.body(other)
        assert model.radius[0, b] == whole.radius[0, c] > 0.0
        assert np.array_equal(model.centroid[0, b], whole.centroid[0, c])
    drawn = here.simulation.body("obstacle_4")
    assert model.radius[0, drawn] == here["obstacle_4"].radius


def test_reading_a_radius_changes_nothing() -> None:
    here = world(obstacle={"shape": COMPOUND, "state": [5, 5, 0]}, robot={**NEIGHBOR, "state": [1, 2, 0]})
    before = here.simulation.model.centroid.copy()
    assert here["obstacle_1"].radius > 0.6
    assert np.array_equal(here.simulation.model.centroid, before)


def test_what_was_explored_stays_explored() -> None:
    here = world(world={"fog_map": True, "fog_map_resolution": 0.5})
    for _ in range(10):
        here.step()
    assert here.simulation.explored is not None
    before = here.simulation.explored.copy()
    here.robot.set_state([8, 2, 0])
    here.add(state=[9, 1, 0])
    here.remove("obstacle_2")
    after = here.simulation.explored
    assert before.any()
    assert after[before].all()


def test_added_wanderers_draw_one_goal_after_the_other_from_the_worlds_stream() -> None:
    here = world()
    wanderer = {**DIFF, "behavior": {"name": "dash", "wander": True}}
    added = [here.create_robot(**wanderer, state=[x, 3, 0]) for x in (3, 5)]
    first = [body.goal for body in added]
    assert not np.array_equal(first[0], first[1])
    here.create_robot(**wanderer, state=[7, 3, 0])
    assert all(np.array_equal(body.goal, goal) for body, goal in zip(added, first, strict=True))
    added[0].set_state(first[0])
    here.step()
    here.step()
    assert not any(np.array_equal(added[0].goal, goal) for goal in first)


def test_a_name_that_is_given_again_inherits_nothing() -> None:
    here = world()
    here.robot.set_goal([2, 2])
    here["robot_1"].set_goal([5, 5])
    for _ in range(3):
        here.step()
    here.remove("robot_1")
    late = here.create_robot(name="robot_1", **DIFF, state=[2, 7, 0], goal=[7, 7])
    here.step()
    assert late.trajectory[:, :2].tolist() == [[2, 7], [2, 7]]
    assert len(here.robot.trajectory) == 5
    here.reset()
    assert late.goals[:, 0].tolist() == [7]
    assert here.robot.goals[:, 0].tolist() == [9]


def test_small_groups_stay_together_when_a_member_is_removed() -> None:
    def companions() -> list[set[str]]:
        (group,) = here.simulation.parts.group_behaviors
        names, party = np.array(here.names)[group.members], group.tables[0].party
        return [set(names[party == number].tolist()) for number in sorted(set(party[party >= 0].tolist()))]

    walkers = {"number": 5, **DIFF, "distribution": {"name": "circle", "radius": 4}}
    here = world(
        robot=[
            {**DIFF, "state": [5, 5, 0]},
            {**walkers, "group_behavior": {"name": "sfm", "social_groups": [[3, 4], [0, 2]]}},
        ],
        obstacle=None,
    )
    assert companions() == [{"robot_4", "robot_5"}, {"robot_1", "robot_3"}]
    here.remove("robot_0")
    assert companions() == [{"robot_4", "robot_5"}, {"robot_1", "robot_3"}]
    here.remove("robot_1")
    assert companions() == [{"robot_4", "robot_5"}, {"robot_3"}]
    here.remove("robot_3")
    assert companions() == [{"robot_4", "robot_5"}]
    here.step()
