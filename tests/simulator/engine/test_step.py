"""Steps against IR-SIM's recorded numbers and against values worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.errors import ScenarioError, UnknownNameError

DIFF: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}


def simulation(robot: Any, obstacle: Any = None, n_worlds: int = 1, agents: tuple[int, ...] = (), **world: Any) -> Any:
    data = {"world": world, "robot": robot, **({"obstacle": obstacle} if obstacle else {})}
    sim = ig.compile(ig.load_scenario(data), n_worlds, agents=agents)
    sim.reset(seed=0)
    return sim


def run(sim: Any, steps: int) -> list[tuple[list[float], list[float]]]:
    rows = []
    for _ in range(steps):
        sim.step()
        rows.append((sim.state.pose[0, 0].tolist(), sim.state.velocity[0, 0, :2].tolist()))
    return rows


def test_dash_follows_ir_sim() -> None:
    # Golden vector of ir-sim 2.12.0.
    sim = simulation({**DIFF, "state": [1, 1, 0], "goal": [9, 9, 0], "behavior": {"name": "dash"}})
    expected = [
        ([1.070710678, 1.0, 0.1], [0.707106781, 1.0]),
        ([1.14746029, 1.007700647, 0.2], [0.771349652, 1.0]),
        ([1.228667265, 1.024162116, 0.3], [0.828586312, 1.0]),
    ]
    for (pose, velocity), (pose_expected, velocity_expected) in zip(run(sim, 3), expected, strict=True):
        assert pose == pytest.approx(pose_expected, abs=1e-9)
        assert velocity == pytest.approx(velocity_expected, abs=1e-9)


def test_dash_with_acceleration_limits_follows_ir_sim() -> None:
    # Golden vector of ir-sim 2.12.0.
    limits = {"vel_max": [2, 2], "vel_min": [-2, -2], "acce": [1, 0.5]}
    sim = simulation({**DIFF, **limits, "state": [1, 1, 0], "goal": [1, 9, 0], "behavior": {"name": "dash"}})
    expected = [
        ([1.0, 1.0, 0.005], [0.0, 0.05]),
        ([1.000999983, 1.000005, 0.015], [0.009999958, 0.1]),
        ([1.003974539, 1.000049622, 0.03], [0.029748907, 0.15]),
        ([1.009871665, 1.000226588, 0.05], [0.058997799, 0.2]),
    ]
    for (pose, velocity), (pose_expected, velocity_expected) in zip(run(sim, 4), expected, strict=True):
        assert pose == pytest.approx(pose_expected, abs=1e-9)
        assert velocity == pytest.approx(velocity_expected, abs=1e-9)


def test_command_is_clipped_and_heading_wraps() -> None:
    sim = simulation({**DIFF, "state": [5, 5, 3.1], "vel_max": [1, 2]}, agents=(0,))
    sim.step([9.0, 2.0])
    assert sim.state.velocity[0, 0, :2].tolist() == [1.0, 2.0]
    assert sim.state.pose[0, 0, 2] == pytest.approx(3.1 + 0.2 - 2 * np.pi)
    assert sim.state.pose[0, 0, :2] == pytest.approx([5 + 0.1 * np.cos(3.1), 5 + 0.1 * np.sin(3.1)])


def test_initial_velocity_is_the_twist_at_the_start() -> None:
    sim = simulation({**DIFF, "state": [5, 5, np.pi / 6], "velocity": [1, 0.5]}, agents=(0,))
    assert sim.state.twist[0, 0] == pytest.approx([np.sqrt(3) / 2, 0.5, 0.5])


def test_upper_limit_wins_over_an_empty_window() -> None:
    robot = {**DIFF, "state": [5, 5, 0], "velocity": [1, 0], "vel_max": [0.3, 1], "acce": [1, 1]}
    sim = simulation(robot, agents=(0,))
    sim.step([1.0, 0.0])
    assert sim.state.velocity[0, 0, 0] == pytest.approx(0.3)


def test_robot_without_behavior_and_learner_stands_still() -> None:
    sim = simulation({**DIFF, "state": [5, 5, 0], "vel_min": [0.5, -1]})
    sim.step()
    assert sim.state.pose[0, 0].tolist() == [5.0, 5.0, 0.0]


@pytest.mark.parametrize(
    ("mode", "robot_moves_on", "obstacle_moves_on"),
    [("stop", False, False), ("unobstructed_obstacles", False, True), ("unobstructed", True, True)],
)
def test_collision_modes(mode: str, robot_moves_on: bool, obstacle_moves_on: bool) -> None:
    robot = {**DIFF, "state": [4, 5, 0], "goal": [9, 5, 0], "behavior": {"name": "dash"}}
    obstacle = {**DIFF, "state": [5, 5, 3.14159], "goal": [1, 5, 0], "behavior": {"name": "dash"}}
    sim = simulation(robot, obstacle, collision_mode=mode)
    while not sim.state.collided[0, 0]:
        sim.step()
    assert sim.state.hit[0].tolist() == [1, 0]
    before = sim.state.pose[0, :, 0].copy()
    sim.step()
    moved = np.abs(sim.state.pose[0, :, 0] - before) > 0.05
    assert moved.tolist() == [robot_moves_on, obstacle_moves_on]
    assert sim.state.collided[0].all()


def test_a_stopped_robot_cannot_reverse_out() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[6, 0], [6, 10]]}}
    sim = simulation({**DIFF, "state": [5.65, 5, 0]}, wall, agents=(0,))
    sim.step([1.0, 0.0])
    sim.step([1.0, 0.0])
    assert sim.state.stopped[0, 0]
    x = sim.state.pose[0, 0, 0]
    sim.step([-1.0, 0.0])
    assert sim.state.pose[0, 0, 0] == x
    assert sim.state.velocity[0, 0].tolist() == [0.0, 0.0, 0.0]


def test_touching_counts_as_collision() -> None:
    disc = {"shape": {"name": "circle", "radius": 0.3}, "state": [6, 5, 0]}
    sim = simulation({**DIFF, "state": [5.4, 5, 0]}, disc, agents=(0,))
    sim.step([1.0, 0.0])
    assert sim.state.pose[0, 0, 0] + 0.2 == pytest.approx(5.7)
    assert bool(sim.state.collided[0, 0]) == (5.4 + 0.1 + 0.2 + 0.3 >= 6.0)


def test_unobstructed_bodies_touch_nobody() -> None:
    ghost = {"shape": {"name": "circle", "radius": 0.5}, "state": [5.5, 5, 0], "unobstructed": True}
    sim = simulation({**DIFF, "state": [5, 5, 0]}, ghost, agents=(0,))
    sim.step([1.0, 0.0])
    assert not sim.state.collided.any()


def test_arrival_is_strict_and_goals_come_in_order() -> None:
    # Binary fractions: after 7 steps the robot is exactly goal_threshold from the first goal, which is not near enough.
    robot = {**DIFF, "state": [1, 1, 0], "goal": [[[2, 1, 0], [3, 1, 0]]], "goal_threshold": 0.125}
    sim = simulation(robot, agents=(0,), step_time=0.125)
    goals = []
    for _ in range(16):
        sim.step([1.0, 0.0])
        goals.append((sim.state.waypoint[0, 0].item(), bool(sim.state.arrived[0, 0])))
    assert goals.index((1, False)) == 7
    assert goals.index((1, True)) == 15


def test_loop_returns_to_the_start() -> None:
    robot = {**DIFF, "state": [1, 1, 0], "goal": [2, 1, 0], "behavior": {"name": "dash", "loop": True}}
    sim = simulation(robot)
    xs = [pose[0] for pose, _ in run(sim, 160)]
    assert max(xs) > 1.9
    assert min(xs[30:]) < 1.15
    assert max(xs[60:]) > 1.5


def test_wander_draws_new_goals_from_the_world_stream() -> None:
    behavior = {"name": "dash", "wander": True, "range_low": [2, 2, -3], "range_high": [8, 8, 3]}
    robot = {**DIFF, "state": [5, 5, 0], "vel_max": [3, 3], "behavior": behavior}
    sim, twin = simulation(robot, n_worlds=3), simulation(robot, n_worlds=3)
    goals = set()
    for _ in range(200):
        sim.step()
        twin.step()
        goals.add(tuple(sim.state.goal[1, 0]))
        np.testing.assert_array_equal(sim.state.pose, twin.state.pose)
    assert len(goals) >= 3
    assert np.all(np.abs(np.array(sorted(goals))[:, :2] - 5) <= 3)


def test_time_does_not_gather_rounding() -> None:
    sim = simulation({**DIFF, "state": [5, 5, 0]}, step_time=0.1)
    for _ in range(1000):
        sim.step()
    assert sim.state.time[0] == 1000 * 0.1


def test_clearance_is_the_surface_distance() -> None:
    obstacles = [
        {"shape": {"name": "circle", "radius": 0.5}, "state": [8, 5, 0]},
        {"shape": {"name": "rectangle", "length": 1, "width": 1}, "state": [5, 7, 0]},
    ]
    sim = simulation({**DIFF, "state": [5, 5, 0]}, obstacles, agents=(0,))
    distance = np.zeros((1, 1))
    sim.clearance(sim.shards.all[0], sim.agents, distance)
    assert distance[0, 0] == pytest.approx(2 - 0.5 - 0.2)
    sim.clearance(sim.shards.all[0], sim.agents, distance, limit=0.3)
    assert distance[0, 0] >= 0.3


def test_robot_placed_in_a_wall_is_refused_with_its_line() -> None:
    wall = {"shape": {"name": "rectangle", "length": 4, "width": 1}, "state": [5, 5, 0]}
    scenario = ig.load_scenario({"robot": {**DIFF, "state": [5, 5.4, 0]}, "obstacle": wall})
    with pytest.raises(ScenarioError, match="the start lies in 'obstacle_1'; a robot"):
        ig.compile(scenario)


def test_unknown_body_offers_the_nearest_name() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'robot_0'"):
        simulation({**DIFF}).body("robot_O")
