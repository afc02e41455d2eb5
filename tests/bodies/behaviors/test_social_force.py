"""Social forces, alone and as a group."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from beside_ir_sim import SAME, count_ties, crowd, silent, theirs

from irsim_gym import compile, load_scenario
from irsim_gym.errors import IrsimGymError, ScenarioError
from irsim_gym.simulator.engine.simulation import Simulation

GOLDEN = """
robot: [{kinematics: {name: omni}, shape: {name: circle, radius: 0.2}, state: [1, 5, 0], goal: [9, 5, 0],
         behavior: {name: sfm}}]
obstacle:
  - {shape: {name: linestring, vertices: [[0, 6], [9, 6]]}, state: [0, 0, 0]}
  - {shape: {name: circle, radius: 0.3}, state: [3, 4.8, 0]}
"""


def simulation(text: str, n: int = 1) -> Simulation:
    made = compile(load_scenario(yaml.safe_load(text)), n_worlds=n)
    made.reset(seed=0)
    return made


def test_golden_walk_between_a_wall_and_a_disc() -> None:
    sim = simulation(GOLDEN)
    expected = [
        ([1.029933012, 4.958320497, 0.0], [0.299330118, -0.416795031]),
        ([1.083117186, 4.885185895, 0.0], [0.531841741, -0.731346017]),
        ([1.155012427, 4.790462212, 0.0], [0.718952411, -0.947236835]),
    ]
    for pose, velocity in expected:
        sim.step()
        np.testing.assert_allclose(sim.state.pose[0, 0], pose, atol=6e-10)
        np.testing.assert_allclose(sim.state.velocity[0, 0, :2], velocity, atol=6e-10)


@pytest.mark.parametrize("drive", ["diff", "omni"])
def test_decisions_are_those_of_ir_sim(drive: str, tmp_path: Path) -> None:
    """Ties are pairs at rest, which rounding pushes to a side: one robot in five begins at rest, as do the discs."""
    random = np.random.default_rng(11)
    total = ties = 0
    for roles, safety in (("all", 0.0), ("all", 0.3), ("robot", 0.0), ("obstacle", 0.0)):
        behavior = {
            "name": "sfm",
            "target_roles": roles,
            "safety_radius": safety,
            "vmax": 1.2,
            "lambda_importance": 1.5,
        }
        compared, tied = count_ties(crowd(random, behavior, drive), tmp_path)
        total, ties = total + compared, ties + tied
    assert total == 24
    assert ties <= 6


PARTIES: dict[str, Any] = {"social_groups": [[0, 2, 5], [1, 3]]}


@pytest.mark.parametrize("drive", ["diff", "omni"])
def test_groups_decide_as_those_of_ir_sim(drive: str, tmp_path: Path) -> None:
    random = np.random.default_rng(12)
    total = ties = 0
    for options in (
        {},
        PARTIES,
        PARTIES | {"target_roles": "robot", "gaze_vision_angle": 20.0, "force_factor_gaze": 1.0},
        PARTIES | {"group_repulsion_threshold": 2.5, "force_factor_coherence": 0.5},
    ):
        scenario = crowd(random, {"name": "sfm"}, drive)
        for robot in scenario["robot"]:
            del robot["behavior"]
            robot.update(group=0, group_behavior={"name": "sfm", **options})
        compared, tied = count_ties(scenario, tmp_path)
        total, ties = total + compared, ties + tied
    assert total == 24
    assert ties <= 4


def test_a_walk_among_walls_is_that_of_ir_sim(tmp_path: Path) -> None:
    """A free run of 60 steps: four that meet between two walls, none of them ever at rest together."""
    ways = [([1, 4.8], [9, 5]), ([1.5, 5.3], [9, 5.2]), ([8, 5.1], [1, 4.9]), ([8.6, 4.7], [1, 5])]
    scenario: dict[str, Any] = {
        "robot": [
            {
                "kinematics": {"name": "omni", "frame": "body"},
                "shape": {"name": "circle", "radius": 0.2},
                "state": [*start, 0.3],
                "goal": [*goal, 0],
                "velocity": [0.3 * k - 0.5, 0.1],
                "vel_max": [1.5, 1.5],
                "vel_min": [-1.5, -1.5],
                "behavior": {"name": "sfm", "force_factor_obstacle": 3.0},
            }
            for k, (start, goal) in enumerate(ways)
        ],
        "obstacle": [
            {"shape": {"name": "linestring", "vertices": [[0, y], [5, y + 0.3], [10, y]]}, "state": [0, 0, 0]}
            for y in (3, 7)
        ],
    }
    env = theirs(scenario, tmp_path)
    sim = compile(load_scenario(copy.deepcopy(scenario)), n_worlds=1)
    sim.reset(seed=0)
    for _ in range(60):
        with silent():
            env.step()
        sim.step()
        np.testing.assert_allclose(sim.state.pose[0, :4], [one.state[:3, 0] for one in env.robot_list], atol=SAME)


STANDER = """
robot: [{kinematics: {name: omni}, shape: {name: circle, radius: 0.2}, state: [5, 5, 0], goal: [5, 5, 0],
         behavior: {name: sfm}}]
"""


@pytest.mark.parametrize(
    "wall",
    [
        "obstacle: [{shape: {name: rectangle, length: 6, width: 1}, state: [5.5, 3.4, 0]}]",
        "obstacle: [{shape: {name: linestring, vertices: [[1, 3.9], [9, 3.9]]}, state: [0, 0, 0]}]",
        """obstacle: [{shape: {name: compound, parts: [{name: circle, radius: 0.5, pose: [3, 0, 0]},
                        {name: circle, radius: 0.5}]}, state: [5, 3.4, 0]}]""",
    ],
)
def test_walls_push_by_their_nearest_point(wall: str) -> None:
    """1.1 m away, with a radius of 0.3 m: 0.1 s * 10 m/s2 * exp(-0.8 / 0.8), straight up; a box pushes once."""
    sim = simulation(STANDER + wall)
    sim.step()
    assert sim.state.command[0, 0, :2] == pytest.approx([0, np.exp(-1)])


@pytest.mark.parametrize(
    ("shape", "place", "push"),
    [
        ({"name": "rectangle", "length": 6, "width": 1}, [5.5, 5.25, 0], [0, -1]),
        ({"name": "rectangle", "length": 6, "width": 1}, [5.5, 4.75, 0], [0, 1]),
        # The nearest edge is that from (4.5, 3.8) to (5.5, 5.8), which looks to the upper left.
        ({"name": "polygon", "vertices": [[-1, -1], [1, -1], [0, 1]]}, [5.5, 4.8, 0], [-np.sqrt(0.8), np.sqrt(0.2)]),
    ],
)
def test_who_stands_inside_an_outline_is_pushed_out_of_it(shape: Any, place: list[float], push: list[float]) -> None:
    """0.1 s * 10 m/s2, out through the nearest point of the outline, which lies less than a radius away."""
    robot = yaml.safe_load(STANDER)["robot"][0] | {"goal_threshold": 0.3, "vel_max": [1, 1]}
    sim = compile(load_scenario({"robot": [robot], "obstacle": [{"shape": shape, "state": [8, 8, 0]}]}))
    sim.reset(seed=0)
    sim.state.pose[0, 1] = place
    sim.place(np.array([1]))
    sim.step()
    assert sim.state.command[0, 0, :2] == pytest.approx(push)


def test_a_disc_of_a_standing_compound_pushes_from_its_edge() -> None:
    """Its centre is 0.9 m away, its edge 0.4 m: 0.1 s * 10 m/s2 * exp(-0.1 / 0.8)."""
    parts = [{"name": "circle", "radius": 0.5}, {"name": "circle", "radius": 0.5, "pose": [3, 0, 0]}]
    robot = yaml.safe_load(STANDER)["robot"][0]
    obstacle = {"shape": {"name": "compound", "parts": parts}, "state": [5, 4.1, 0]}
    sim = compile(load_scenario({"robot": [robot], "obstacle": [obstacle]}))
    sim.reset(seed=0)
    sim.step()
    assert sim.state.command[0, 0, :2] == pytest.approx([0, np.exp(-0.125)])


def test_a_map_pushes_once_for_each_direction() -> None:
    """A floor below and a wall to the right, both 1 m from the centre, whatever the number of cells; hidden by role."""
    cells = np.zeros((50, 50), np.bool_)
    cells[:, :20] = cells[30:, :] = True
    floor = {"width": 10, "height": 10, "obstacle_map": cells}
    for roles, push in (("all", np.exp(-0.7 / 0.8)), ("robot", 0.0)):
        robot = yaml.safe_load(STANDER)["robot"][0]
        robot["behavior"]["target_roles"] = roles
        sim = compile(load_scenario({"world": floor, "robot": [robot]}), n_worlds=1)
        sim.reset(seed=0)
        sim.step()
        assert sim.state.command[0, 0, :2] == pytest.approx([-push, push])


def test_the_edge_of_a_map_that_ends_beside_the_robot() -> None:
    """All that is occupied lies eight metres away: nothing below the lower edge of the map, nothing pushes."""
    cells = np.zeros((50, 50), np.bool_)
    cells[:, -1] = cells[-1, :] = True
    robot = yaml.safe_load(STANDER)["robot"][0] | {"state": [1, 1, 0], "goal": [1, 1, 0]}
    sim = compile(load_scenario({"world": {"width": 10, "height": 10, "obstacle_map": cells}, "robot": [robot]}))
    sim.reset(seed=0)
    sim.step()
    assert sim.state.command[0, 0].tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("behavior", ["sfm", "rvo"])
def test_who_has_no_goal_stands_still(behavior: str) -> None:
    robot = {"kinematics": {"name": "omni"}, "state": [5, 5, 0], "behavior": {"name": behavior}}
    sim = compile(load_scenario({"robot": [robot]}))
    sim.reset(seed=0)
    sim.state.command[:] = 9.0
    sim.step()
    assert sim.state.command[0, 0].tolist() == [0.0, 0.0, 0.0]


def test_two_in_the_same_place_do_not_push_each_other() -> None:
    robots = {"number": 2, "kinematics": {"name": "omni"}, "state": [[5, 5, 0], [5, 5, 0]], "goal": [9, 5, 0]}
    robots |= {"distribution": {"name": "manual"}, "behavior": {"name": "sfm", "vmax": 1.0}}
    world = {"collision_mode": "unobstructed", "update": "simultaneous"}
    sim = compile(load_scenario({"world": world, "robot": robots}, warn=False))
    sim.reset(seed=0)
    sim.step()
    # The pull alone: (1 m/s - 0) / 0.54 s over a step of 0.1 s.
    pull = 0.1 / sim.parts.turns[0].behaviors[0].params[0].relaxation_time
    np.testing.assert_allclose(sim.state.command[0, :, :2], [[pull, 0.0]] * 2, rtol=1e-12)


def walk(steps: int, world: dict[str, Any], obstacles: list[dict[str, Any]], goal: list[float]) -> Any:
    robot = yaml.safe_load(STANDER)["robot"][0]
    robot |= {"state": [0.6, 4.6, 0], "goal": goal, "vel_max": [1.5, 1.5], "vel_min": [-1.5, -1.5]}
    sim = compile(load_scenario({"world": world, "robot": [robot], "obstacle": obstacles}), n_worlds=1)
    sim.reset(seed=0)
    path = []
    for _ in range(steps):
        sim.step()
        path.append(sim.state.pose[0, 0, :2].copy())
    return np.array(path)


def test_a_corridor_of_cells_is_walked_as_one_of_linestrings() -> None:
    cells = np.zeros((50, 50), np.bool_)
    cells[:, :20] = cells[:, 32:] = True
    lines = [{"shape": {"name": "linestring", "vertices": [[0, y], [10, y]]}, "state": [0, 0, 0]} for y in (4.0, 6.4)]
    of_cells, of_lines = walk(60, {"obstacle_map": cells}, [], [9.4, 5.6]), walk(60, {}, lines, [9.4, 5.6])
    np.testing.assert_allclose(of_cells, of_lines, atol=1e-9)
    assert of_cells[-1, 0] > 8.0


def test_a_block_of_cells_pushes_as_the_box_does() -> None:
    """Also where its corner is nearest: two sides of the block end there, and push once."""
    cells = np.zeros((50, 50), np.bool_)
    cells[15:35, :14] = True
    box = {"shape": {"name": "rectangle", "length": 4, "width": 2.8}, "state": [5, 1.4, 0]}
    of_cells, of_box = walk(70, {"obstacle_map": cells}, [], [9.4, 3.4]), walk(70, {}, [box], [9.4, 3.4])
    np.testing.assert_allclose(of_cells, of_box, atol=1e-9)
    assert of_cells[-1, 0] > 8.0


def test_a_slanted_wall_of_cells_pushes_about_as_a_line_does() -> None:
    """The robot stands still, 1.2 m from the line through the steps' outer corners, which face up and to the left."""
    cells = np.tril(np.ones((100, 100), np.bool_), -1)
    push = []
    for world in ({"obstacle_map": cells}, {}):
        robot = yaml.safe_load(STANDER)["robot"][0]
        away = 1.2 / np.sqrt(2.0)
        robot |= {"state": [5 - away, 5 + away, 0], "goal": [5 - away, 5 + away, 0]}
        line = {"shape": {"name": "linestring", "vertices": [[0, 0], [10, 10]]}, "state": [0, 0, 0]}
        data = {"world": world, "robot": [robot], "obstacle": [] if world else [line]}
        sim = compile(load_scenario(data), n_worlds=1)
        sim.reset(seed=0)
        sim.step()
        push.append(sim.state.command[0, 0, :2].copy())
    np.testing.assert_allclose(push[0], push[1], rtol=0.1)
    assert push[1] == pytest.approx([-np.exp(-0.9 / 0.8) / np.sqrt(2), np.exp(-0.9 / 0.8) / np.sqrt(2)])


def test_a_member_without_goal_gives_way() -> None:
    text = """
robot: {number: 2, distribution: {name: manual}, kinematics: {name: omni}, state: [[5, 5, 0], [5.5, 5, 0]],
        velocity: [[0, 0], [-1, 0.2]], group_behavior: {name: sfm}}
"""
    sim = simulation(text)
    sim.step()
    assert sim.state.command[0, 0, 0] < -0.01


@pytest.mark.parametrize(
    ("parties", "message"),
    [
        ([[0, 1], [1, 2]], "member 1 is listed twice"),
        ([[0, -1]], "members are counted from 0, got -1"),
        ([[0, 3]], "names member 3, but the group has 2 members"),
    ],
)
def test_parties_are_checked(parties: list[list[int]], message: str) -> None:
    robots = {"number": 2, "kinematics": {"name": "omni"}, "state": [[1, 1, 0], [2, 2, 0]]}
    robots["group_behavior"] = {"name": "sfm", "social_groups": parties}
    with pytest.raises((ScenarioError, IrsimGymError), match=message):
        compile(load_scenario({"robot": robots}))
