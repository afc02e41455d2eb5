"""Commands that override behaviours for one step, and poses written from outside."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.errors import ScenarioError

DIFF: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}
DASH = {**DIFF, "state": [1, 1, 0], "goal": [9, 1, 0], "behavior": {"name": "dash"}}
IDLE = {**DIFF, "state": [1, 5, 0], "vel_min": [0.2, -1]}


def simulation(n_worlds: int = 1, **sections: Any) -> Any:
    sim = ig.compile(ig.load_scenario({"robot": [DASH, IDLE], **sections}), n_worlds)
    sim.reset(seed=0)
    return sim


def test_orders_override_a_behaviour_for_one_step_and_are_clipped() -> None:
    sim = simulation(n_worlds=2)
    sim.step([[0.5, 7.0]], bodies=np.array([0]))
    assert sim.state.velocity[:, 0, :2].tolist() == [[0.5, 1.0]] * 2
    for world in range(2):
        assert sim.state.pose[world, 0].tolist() == pytest.approx([1.05, 1.0, 0.1])
    sim.step()
    assert sim.state.velocity[0, 0, 0] == pytest.approx(np.cos(0.1), abs=1e-9)  # dash drives again: the goal is at -0.1


def test_a_body_that_nobody_drives_stands_again_after_an_order() -> None:
    sim = simulation()
    sim.step([[0.0, 0.0]], bodies=np.array([1]))
    assert sim.state.velocity[0, 1, 0] == 0.2  # a zero command is clipped as well, as in IR-SIM
    sim.step()
    assert sim.state.velocity[0, 1].tolist() == [0.0, 0.0, 0.0]
    assert sim.state.pose[0, 1].tolist() == pytest.approx([1.02, 5.0, 0.0])


def test_commands_that_nobody_takes_or_of_a_wrong_shape_are_errors() -> None:
    sim = simulation(n_worlds=3)
    with pytest.raises(ValueError, match=r"nobody takes them: compile\(scenario, agents=\[0\]\)"):
        sim.step([0.5, 0.5])
    led = ig.compile(ig.load_scenario({"robot": [DASH, IDLE], "obstacle": [{}]}), 3, agents=[0, 1])
    led.reset(seed=0)
    for wrong in ([1, 2, 3, 4], 0.5, [0.5], np.zeros((2, 2, 2)), np.zeros((3, 3, 2)), np.zeros((1, 3, 2, 2))):
        with pytest.raises(ValueError, match=r"commands are 2 numbers \(linear, angular\).* = \(3, 2, 2\)") as told:
            led.step(wrong)
        assert str(told.value).endswith(f"got shape {np.shape(wrong)}")
    with pytest.raises(
        ValueError, match=r"bodies= takes indices .* 0 'robot_0', 1 'robot_1', 2 'obstacle_2'; got \[3\]"
    ):
        led.step([0.5, 0.5], bodies=[3])
    with pytest.raises(ValueError, match="'obstacle_2' takes no commands: it has no kinematics"):
        led.step([0.5, 0.5], bodies=[2])
    for fits in ([0.5, 0.0], [[0.5, 0.0]] * 2, np.full((3, 1, 2), [0.5, 0.0]), np.full((1, 2, 3), [0.5, 0.0, 9.0])):
        led.reset(seed=0)
        led.step(fits)
        assert led.state.velocity[:, :2, 0].tolist() == [[0.5, 0.5]] * 3


def test_what_is_no_scenario_no_agent_or_no_level_is_told() -> None:
    scenario = ig.load_scenario({"robot": [DASH]})
    with pytest.raises(TypeError, match=r"takes a scenario, got str: compile\(load_scenario\('corridor'\)\)"):
        ig.compile("corridor")  # type: ignore[arg-type]
    for wrong in ([1], [-1], ["robot_0"], [0.5], 0):
        with pytest.raises(ValueError, match=r"agents= takes indices of bodies, e\.g\. \[0\]; there are 0 'robot_0'"):
            ig.compile(scenario, agents=wrong)  # type: ignore[arg-type]
    sim = ig.compile(scenario, 2)
    sim.reset(seed=2**63 - 2)
    for level in (2**63 - 1, 2**70, -1):
        with pytest.raises(ValueError, match=f"from 0 to {2**63 - 2}, got {level}"):
            sim.reset(seed=level)
    with pytest.raises(TypeError, match=r"a seed is a whole number, got 1\.5"):
        sim.reset(seed=1.5)  # type: ignore[arg-type]


def test_reset_to_start_repeats_the_level() -> None:
    scenario = {"robot": [{**DASH, "distribution": {"name": "random"}, "behavior": {"name": "dash", "wander": True}}]}
    sim = ig.compile(ig.load_scenario(scenario))
    sim.reset(seed=3)
    first = sim.state.pose.copy(), sim.state.goal.copy(), sim.state.random.copy()
    for _ in range(5):
        sim.step()
    sim.reset_to_start()
    assert sim.state.step[0] == 0
    for field, before in zip((sim.state.pose, sim.state.goal, sim.state.random), first, strict=True):
        assert np.array_equal(field, before)
    sim.reset(seed=3, episode=1)
    assert not np.array_equal(sim.state.pose, first[0])


def test_what_follows_a_pose_written_from_outside() -> None:
    wall = {"shape": {"name": "rectangle", "length": 1, "width": 1}, "state": [5, 5, 0]}
    sim = simulation(obstacle=[wall, wall], robot=DASH)
    assert sim.state.discs[0, 0].tolist() == pytest.approx([1, 1, 0.2])
    sim.state.pose[0, 0] = [4.4, 5.0, np.pi / 2]
    sim.state.velocity[0, 0] = [1.0, 0.5, 0.0]
    sim.place(np.array([0]))
    assert sim.state.discs[0, 0].tolist() == pytest.approx([4.4, 5, 0.2])
    assert sim.state.twist[0, 0].tolist() == pytest.approx([0, 1, 0.5])
    assert not sim.state.collided[0, 0]
    sim.refresh()
    assert sim.state.collided[0].tolist() == [True, True, True]
    sim.state.pose[0, 2] = [9.0, 9.0, 0.0]  # the second wall leaves the first, which never moves by itself
    sim.place(np.array([2]))
    sim.refresh()
    assert sim.state.collided[0].tolist() == [True, True, False]


def test_starts_in_walls_may_be_allowed() -> None:
    wall = {"shape": {"name": "rectangle", "length": 1, "width": 1}, "state": [1, 1, 0]}
    scenario = ig.load_scenario({"robot": DASH, "obstacle": wall})
    with pytest.raises(ScenarioError, match="must begin clear"):
        ig.compile(scenario)
    ig.compile(scenario, check_starts=False)


def test_a_start_in_a_wall_holds_nobody_where_collisions_do_not_count() -> None:
    wall = {"shape": {"name": "rectangle", "length": 1, "width": 1}, "state": [1, 1, 0]}
    world = {"collision_mode": "unobstructed"}
    sim = ig.compile(ig.load_scenario({"world": world, "robot": DASH, "obstacle": wall}))
    sim.reset()
    before = sim.state.pose[0, 0].copy()
    sim.step()
    assert sim.state.collided[0].all()
    assert (sim.state.pose[0, 0] != before).any()


def test_nobody_learns_where_nothing_moves() -> None:
    with pytest.raises(ScenarioError, match=r"world\.step_mode: the bodies do not move by themselves"):
        ig.make({"world": {"step_mode": "external"}, "robot": DASH})


def test_numbers_from_a_worlds_stream() -> None:
    sim = simulation()
    before = sim.state.random.copy()
    drawn = sim.uniform([0.0, 5.0], [1.0, 6.0])
    assert 0 <= drawn[0] < 1
    assert 5 <= drawn[1] < 6
    assert sim.state.random[0] != before[0]
