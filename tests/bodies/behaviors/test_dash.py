"""Dash for each drive: IR-SIM's recorded numbers and its own functions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from irsim.lib.behavior import behavior_methods as theirs

import irsim_gym as ig

DASH = {"name": "dash"}
# Golden vectors of ir-sim 2.12.0: state after each step, velocity of that step.
GOLDEN: dict[str, tuple[dict[str, Any], list[tuple[list[float], list[float]]]]] = {
    "diff": (
        {"kinematics": {"name": "diff"}, "state": [1, 1, 0], "goal": [9, 9, 0]},
        [
            ([1.070710678, 1.0, 0.1], [0.707106781, 1.0]),
            ([1.14746029, 1.007700647, 0.2], [0.771349652, 1.0]),
            ([1.228667265, 1.024162116, 0.3], [0.828586312, 1.0]),
        ],
    ),
    "diff with limited acceleration": (
        {
            "kinematics": {"name": "diff"},
            "state": [1, 1, 0],
            "goal": [1, 9, 0],
            "vel_max": [2, 2],
            "vel_min": [-2, -2],
            "acce": [1, 0.5],
        },
        [
            ([1.0, 1.0, 0.005], [0.0, 0.05]),
            ([1.000999983, 1.000005, 0.015], [0.009999958, 0.1]),
            ([1.003974539, 1.000049622, 0.03], [0.029748907, 0.15]),
            ([1.009871665, 1.000226588, 0.05], [0.058997799, 0.2]),
        ],
    ),
    "acker": (
        {
            "kinematics": {"name": "acker"},
            "shape": {"name": "rectangle", "length": 4.6, "width": 1.6, "wheelbase": 3},
            "state": [1, 1, 0, 0],
            "goal": [40, 40, 0],
            "vel_max": [4, 1],
        },
        [
            ([1.4, 1.0, 0.0, 0.785398163], [4.0, 0.785398163]),
            ([1.8, 1.0, 0.133333333, 0.790552757], [4.0, 0.790552757]),
            ([2.196449709, 1.053175449, 0.268048359, 0.662427153], [4.0, 0.662427153]),
        ],
    ),
    "omni": (
        {"kinematics": {"name": "omni", "frame": "body"}, "state": [1, 1, 0.5], "goal": [4, 5], "vel_max": [1, 0.5]},
        [
            ([1.069933954, 1.061816019, 0.5], [0.910089968, 0.207205363]),
            ([1.139643866, 1.123708669, 0.5], [0.908491202, 0.208951989]),
        ],
    ),
    "omni_angular": (
        {"kinematics": {"name": "omni_angular"}, "state": [1, 1, 0.5], "goal": [4, 5, 0], "acce": [2, 2, 0.5]},
        [([1.00796314, 1.027140162, 0.505], [0.2, 0.2, 0.05]), ([1.023617822, 1.081499439, 0.515], [0.4, 0.4, 0.1])],
    ),
}


def simulation(robots: Any, n_worlds: int = 1) -> ig.Simulation:
    sim = ig.compile(ig.load_scenario({"robot": robots}, warn=False), n_worlds)
    sim.reset(seed=0)
    return sim


@pytest.mark.parametrize("case", GOLDEN)
def test_recorded_runs(case: str) -> None:
    robot, rows = GOLDEN[case]
    sim = simulation({"shape": {"name": "circle"}, "behavior": DASH, **robot})
    for state, velocity in rows:
        sim.step()
        found = np.append(sim.state.pose[0, 0], sim.state.steering[0, 0])
        assert found[: len(state)] == pytest.approx(state, abs=1e-9)
        assert sim.state.velocity[0, 0, : len(velocity)] == pytest.approx(velocity, abs=1e-9)


def their_command(name: str, pose: Any, goal: Any, fastest: Any, threshold: float) -> Any:
    pose, goal, fastest = (np.array(values, float)[:, None] for values in (pose, goal, fastest))
    if name == "omni":
        return theirs.OmniDash(pose, goal, fastest, threshold)
    if name == "acker":
        return theirs.AckerDash(pose, goal, fastest, threshold, 0.2)
    decide = theirs.DiffDash if name == "diff" else theirs.OmniAngularDash
    return decide(pose, goal, fastest, threshold, 0.2, 3.0, 0.1)


@pytest.mark.parametrize("name", ["diff", "omni", "omni_angular", "acker"])
def test_commands_are_ir_sims(name: str) -> None:
    kinematics = {"name": name, **({"frame": "body"} if name == "omni" else {})}
    kinematics |= {"wheelbase": 1} if name == "acker" else {}
    fastest = [1.5, 0.7, 1.2] if name == "omni_angular" else [1.5, 0.7]
    robot = {
        "kinematics": kinematics,
        "vel_max": fastest,
        "acce": [3.0] * len(fastest),
        "goal": [4, 5, 1.0],
        "goal_threshold": 0.5,
        "behavior": {"name": "dash", "angle_tolerance": 0.2},
    }
    n_worlds = 60
    sim = simulation(robot, n_worlds)
    random = np.random.default_rng(2)
    sim.state.pose[:, 0] = random.uniform([2, 3, -3.2], [6, 7, 3.2], (n_worlds, 3))
    sim.state.pose[:5, 0] = [[4, 4.5, 0], [6, 5, 0], [2, 5, np.pi], [3.5, 5, -np.pi], [4.1, 5, 0]]
    poses = sim.state.pose[:, 0].copy()
    group = sim.parts.behaviors[0]
    group.kind.decide(group, sim.model, sim.state, sim.shards.all[0])
    for w, pose in enumerate(poses):
        expected = their_command(name, pose, [4, 5, 1.0], fastest, 0.5)[:, 0]
        found = sim.state.command[w, 0]
        assert found[: len(expected)] == pytest.approx(expected, abs=1e-12), pose
        assert not found[len(expected) :].any()


def test_omni_in_the_world_frame_shares_out_its_limits_there() -> None:
    robot = {
        "kinematics": {"name": "omni"},
        "state": [1, 1, 0.5],
        "goal": [4, 5],
        "vel_max": [1, 0.5],
        "behavior": DASH,
    }
    sim = simulation(robot)
    sim.step()
    assert sim.state.velocity[0, 0] == pytest.approx([0.6, 0.4, 0])
    assert sim.state.pose[0, 0] == pytest.approx([1.06, 1.04, 0.5])


def test_a_goal_without_heading_is_not_turned_to() -> None:
    robot = {"kinematics": {"name": "omni_angular"}, "state": [4, 5, 0.5], "goal": [4, 5], "behavior": DASH}
    sim = simulation(robot)
    sim.step()
    assert not sim.state.velocity.any()


def test_drives_do_not_get_into_each_others_way() -> None:
    robots = [{"state": [1, 1], "goal": [9, 9], "behavior": DASH, **robot} for robot, _ in GOLDEN.values()]
    robots = [{**robot, "shape": {"name": "circle", "wheelbase": 3}, "unobstructed": True} for robot in robots]
    together = simulation(robots)
    alone = [simulation(robot) for robot in robots]
    for _ in range(5):
        for sim in (together, *alone):
            sim.step()
    for b, sim in enumerate(alone):
        np.testing.assert_array_equal(together.state.pose[0, b], sim.state.pose[0, 0])


def test_one_without_a_goal_stands_and_those_behind_it_in_the_list_drive() -> None:
    drive = {"kinematics": {"name": "omni_angular"}, "behavior": {"name": "dash"}}
    robots = [{**drive, "state": [2, 2, 0]}, {**drive, "state": [2, 5, 0], "goal": [8, 5, 0]}]
    sim = ig.compile(ig.load_scenario({"robot": robots}, warn=False))
    sim.reset(seed=0)
    sim.step()
    assert sim.state.command[0, 0].tolist() == [0.0, 0.0, 0.0]
    assert sim.state.command[0, 1, 0] > 0.0
